#include "runtime/sim/state/share_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "runtime/base/hash.h"
#include "runtime/base/process/liveness.h"

namespace meld::sim {

namespace {

constexpr char kMagic[16] = "meld snapshot 8";

// Of the kind and the bytes, and thereby of the length: a file that ends after a whole block lacks the last kind.
std::uint64_t hash_of(ShareBlock kind, BlockView block) { return hash_bytes(block, static_cast<std::uint64_t>(kind)); }

struct BlockHead {
    ShareBlock kind = ShareBlock::Rest;
    std::uint64_t size = 0;
    std::uint64_t hash = 0;
};

tl::unexpected<Error> damaged_share(const std::string& path, const std::string& what) {
    return fail(path + " " + what, "It is damaged, or was not written to its end", ExitCode::RecordingRefused);
}

}  // namespace

Result<std::unique_ptr<ShareWriter>> ShareWriter::create(const std::string& path) {
    Result<OutputFile> file = OutputFile::open(path, Appears::Whole, Durability::Machine);
    if (!file) return tl::unexpected<Error>(file.error());
    std::unique_ptr<ShareWriter> writer(new ShareWriter(std::move(*file)));
    writer->file_.write({kMagic, sizeof kMagic});
    return writer;
}

void ShareWriter::write(ShareBlock kind, BlockView block) {
    const BlockHead head{kind, block.size(), hash_of(kind, block)};
    file_.write({reinterpret_cast<const char*>(&head), sizeof head});
    file_.write({reinterpret_cast<const char*>(block.data()), block.size()});
}

Result<void> ShareWriter::chunk(const Chunk& chunk) {
    write(ShareBlock::Places, chunk.places);
    write(ShareBlock::State, chunk.state);
    return {};
}

Result<void> ShareWriter::rest(BlockView rest) {
    write(ShareBlock::Rest, rest);
    return {};
}

Result<void> ShareWriter::reserve(std::uint64_t bytes) { return file_.reserve(bytes); }

Result<void> ShareWriter::close() { return file_.commit(); }

namespace {

bool read_at(std::FILE* file, std::uint64_t offset, void* to, std::size_t size) {
    return fseeko(file, static_cast<off_t>(offset), SEEK_SET) == 0 && std::fread(to, 1, size, file) == size;
}

}  // namespace

Result<ShareFiles> ShareFiles::open(const std::vector<std::string>& paths) {
    ShareFiles out;
    for (const std::string& path : paths) {
        Result<File> file = index(path);
        if (!file) return tl::unexpected<Error>(file.error());
        if (out.files_.size() >= kMostHeld) file->held.reset();
        for (const Place& place : file->blocks) out.largest_ = std::max(out.largest_, place.size);
        out.files_.push_back(std::move(*file));
    }
    return out;
}

Result<ShareFiles::Open> ShareFiles::open_one(const std::string& path) {
    // Neither a device nor a pipe, which might never end.
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return damaged_share(path, "is missing, or no file of ours");
    Open file(std::fopen(path.c_str(), "rbe"));
    if (!file) return fail(fmt::format("cannot read {}: {}", path, std::strerror(errno)), "", ExitCode::RecordingRefused);
    return file;
}

// Only the heads of the blocks are read.
Result<ShareFiles::File> ShareFiles::index(const std::string& path) {
    Result<Open> in = open_one(path);
    if (!in) return tl::unexpected<Error>(in.error());
    fseeko(in->get(), 0, SEEK_END);
    const auto size = static_cast<std::uint64_t>(ftello(in->get()));
    char magic[sizeof kMagic] = {};
    if (!read_at(in->get(), 0, magic, sizeof magic) || std::memcmp(magic, kMagic, sizeof magic) != 0)
        return damaged_share(path, "is no snapshot of this version");
    File out{path, {}, std::move(*in)};
    for (std::uint64_t at = sizeof kMagic; at < size;) {
        BlockHead head;
        if (size - at < sizeof head || !read_at(out.held.get(), at, &head, sizeof head) || head.size > size - at - sizeof head)
            return damaged_share(path, fmt::format("ends in the midst of a block at byte {}", at));
        const bool ended = !out.blocks.empty() && out.blocks.back().kind == ShareBlock::Rest;
        const bool after_places = !out.blocks.empty() && out.blocks.back().kind == ShareBlock::Places;
        if (ended || (head.kind == ShareBlock::State) != after_places || head.kind > ShareBlock::Rest)
            return damaged_share(path, fmt::format("has a block at byte {} that does not belong there", at));
        out.blocks.push_back({head.kind, at + sizeof head, head.size, head.hash});
        at += sizeof head + head.size;
    }
    if (out.blocks.empty() || out.blocks.back().kind != ShareBlock::Rest) return damaged_share(path, "lacks its last block");
    return out;
}

Result<void> ShareFiles::check() const {
    Block room;
    for (std::size_t share = 0; share < files_.size(); ++share)
        for (std::size_t block = 0; block < files_[share].blocks.size(); ++block)
            if (const Result<BlockView> whole = read(share, block, room); !whole) return tl::unexpected<Error>(whole.error());
    return {};
}

Result<BlockView> ShareFiles::read(std::size_t share, std::size_t block, Block& room) const {
    liveness::beat();
    const File& file = files_[share];
    const Place& place = file.blocks[block];
    // At once as much as any block takes: to grow means to copy, and new memory comes from the system page by page.
    if (room.size() < place.size) room = Block(largest_);
    const std::span<std::byte> out(room.data(), place.size);
    Open again;
    if (!file.held) {
        Result<Open> opened = open_one(file.path);
        if (!opened) return tl::unexpected<Error>(opened.error());
        again = std::move(*opened);
    }
    if (!read_at(file.held ? file.held.get() : again.get(), place.offset, out.data(), place.size))
        return damaged_share(file.path, fmt::format("cannot be read at byte {}", place.offset));
    if (hash_of(place.kind, out) != place.hash)
        return damaged_share(file.path, fmt::format("has other bytes than were written, after byte {}", place.offset));
    return out;
}

}  // namespace meld::sim
