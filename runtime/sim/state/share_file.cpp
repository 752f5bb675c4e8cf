#include "runtime/sim/state/share_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <span>

#include "runtime/base/hash.h"
#include "runtime/base/process/liveness.h"

namespace meld::sim {

namespace {

// Of a share that refers to no other file, and of one that may.
constexpr char kMagic[16] = "meld snapshot18", kChangesMagic[16] = "meld snapshot19";
// A bit of the kind: the block says where its bytes are.
constexpr std::uint64_t kElsewhere = 1u << 8;
constexpr std::uint64_t kMostNames_bytes = 1 << 24;

// Of the kind and the bytes, and thereby of the length: a file that ends after a whole block lacks the last kind.
std::uint64_t hash_of(std::uint64_t kind, BlockView block) { return hash_bytes(block, kind); }

struct BlockHead {
    std::uint64_t kind = 0;
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

Result<std::unique_ptr<ShareWriter>> ShareWriter::create(const std::string& path, const WrittenBlocks& before) {
    Result<OutputFile> file = OutputFile::open(path, Appears::Whole, Durability::Machine);
    if (!file) return tl::unexpected<Error>(file.error());
    std::unique_ptr<ShareWriter> writer(new ShareWriter(std::move(*file)));
    writer->before_ = &before;
    writer->written_.emplace(WrittenBlocks{.files = before.files, .blocks = {}, .chunks = {}});
    const bool whole = before.files.empty();
    writer->file_.write({whole ? kMagic : kChangesMagic, sizeof kMagic});
    if (!whole) {
        std::string names;
        for (const std::string& name : before.files) names += name + "\n";
        const auto kind = static_cast<std::uint64_t>(ShareBlock::Names);
        const BlockView bytes = std::as_bytes(std::span(names));
        writer->write_as_it_is(kind, bytes, hash_of(kind, bytes));
    }
    writer->written_->files.push_back(std::filesystem::path(path).filename().string());
    return writer;
}

std::size_t ShareWriter::chunk_catoms() const { return written_ ? kCatomsOfASmallChunk : ShareSink::chunk_catoms(); }

void ShareWriter::write_as_it_is(std::uint64_t kind, BlockView block, std::uint64_t hash) {
    const BlockHead head{kind, block.size(), hash};
    file_.write({reinterpret_cast<const char*>(&head), sizeof head});
    file_.write({reinterpret_cast<const char*>(block.data()), block.size()});
}

void ShareWriter::write_elsewhere(std::uint64_t kind, const WrittenBlocks::Place& place) {
    const BlockView where = std::as_bytes(std::span(&place, 1));
    write_as_it_is(kind | kElsewhere, where, hash_of(kind | kElsewhere, where));
}

WrittenBlocks::Known ShareWriter::write(ShareBlock kind, BlockView block) {
    const auto number = static_cast<std::uint64_t>(kind);
    const std::uint64_t hash = hash_of(number, block);
    if (!written_) {
        write_as_it_is(number, block, hash);
        return {};
    }
    // Of 128 bits, so that no two blocks are taken for one.
    const XXH128_hash_t content = XXH3_128bits_withSeed(block.data(), block.size(), number);
    const WrittenBlocks::Content key(content.low64, content.high64);
    const bool is_short = block.size() <= sizeof(WrittenBlocks::Place);
    WrittenBlocks::Place place{
        .file = written_->files.size() - 1, .offset = size() + sizeof(BlockHead), .size = block.size(), .hash = hash};
    if (const auto known = before_->blocks.find(key); known != before_->blocks.end() && !is_short) {
        place = known->second;
        write_elsewhere(number, place);
    } else {
        write_as_it_is(number, block, hash);
    }
    written_->blocks.try_emplace(key, place);
    WrittenBlocks::Known known{.content = key};
    if (is_short) known.bytes.assign(block.begin(), block.end());
    return known;
}

Result<void> ShareWriter::chunk(const Chunk& chunk) {
    WrittenBlocks::Known places = write(ShareBlock::Places, chunk.places), state = write(ShareBlock::State, chunk.state);
    if (written_ && chunk.number != kNoChunk) written_->chunks[chunk.number] = {std::move(places), std::move(state)};
    return {};
}

bool ShareWriter::take_as_before(std::size_t number) {
    if (before_ == nullptr) return false;
    const auto chunk = before_->chunks.find(number);
    if (chunk == before_->chunks.end()) return false;
    for (const ShareBlock kind : {ShareBlock::Places, ShareBlock::State}) {
        const WrittenBlocks::Known& known = chunk->second[kind == ShareBlock::State];
        if (!known.bytes.empty()) {
            write(kind, known.bytes);
            continue;
        }
        const WrittenBlocks::Place& place = before_->blocks.at(known.content);
        write_elsewhere(static_cast<std::uint64_t>(kind), place);
        written_->blocks.try_emplace(known.content, place);
    }
    written_->chunks.insert(*chunk);
    return true;
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
    std::size_t held = 0;
    for (const std::string& path : paths) {
        Result<File> file = index(path);
        if (!file) return tl::unexpected<Error>(file.error());
        for (Source& each : file->sources)
            if (each.held && ++held > kMostHeld) each.held.reset();
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

Result<ShareFiles::Source> ShareFiles::source(const std::string& path) {
    Result<Open> in = open_one(path);
    if (!in) return tl::unexpected<Error>(in.error());
    fseeko(in->get(), 0, SEEK_END);
    const auto size = static_cast<std::uint64_t>(ftello(in->get()));
    return Source{path, std::move(*in), size};
}

// A line for each. A name alone: a share cannot lead out of its folder.
Result<void> ShareFiles::name_sources(File& file, const std::string& names) {
    const std::string path = file.sources[0].path;
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    if (names.empty()) return damaged_share(path, "names no file");
    for (std::size_t at = 0; at < names.size();) {
        const std::size_t end = names.find('\n', at);
        const std::string name = names.substr(at, end == std::string::npos ? end : end - at);
        if (end == std::string::npos || name.empty() || name.find('/') != std::string::npos || name.find('\0') != std::string::npos)
            return damaged_share(path, "names files that are none");
        file.sources.push_back({.path = (folder / name).string()});
        at = end + 1;
    }
    return {};
}

// What the block at this offset refers to. A file is opened when something is in it.
Result<ShareFiles::Place> ShareFiles::find_elsewhere(File& file, ShareBlock kind, std::uint64_t offset) {
    const std::string& path = file.sources[0].path;
    WrittenBlocks::Place place;
    if (!read_at(file.sources[0].held.get(), offset, &place, sizeof place)) return damaged_share(path, "cannot be read");
    if (place.file + 1 >= file.sources.size()) return damaged_share(path, "refers to a file that it does not name");
    Source& in = file.sources[place.file + 1];
    if (!in.held) {
        Result<Source> opened = source(in.path);
        if (!opened) return tl::unexpected<Error>(opened.error());
        in = std::move(*opened);
    }
    if (place.offset > in.size || place.size > in.size - place.offset)
        return damaged_share(in.path, fmt::format("is shorter than {} says", path));
    return Place{kind, place.file + 1, place.offset, place.size, place.hash};
}

// Only the heads of the blocks are read, and what refers to others.
Result<ShareFiles::File> ShareFiles::index(const std::string& path) {
    Result<Source> in = source(path);
    if (!in) return tl::unexpected<Error>(in.error());
    const std::uint64_t size = in->size;
    File out;
    out.sources.push_back(std::move(*in));
    const auto file = [&] { return out.sources[0].held.get(); };
    char magic[sizeof kMagic] = {};
    const bool read = read_at(file(), 0, magic, sizeof magic);
    const bool changes = read && std::memcmp(magic, kChangesMagic, sizeof magic) == 0;
    if (!changes && (!read || std::memcmp(magic, kMagic, sizeof magic) != 0)) return damaged_share(path, "is no snapshot of this version");
    bool named = !changes;
    for (std::uint64_t at = sizeof kMagic; at < size;) {
        BlockHead head;
        if (size - at < sizeof head || !read_at(file(), at, &head, sizeof head) || head.size > size - at - sizeof head)
            return damaged_share(path, fmt::format("ends in the midst of a block at byte {}", at));
        const auto kind = static_cast<ShareBlock>(head.kind & ~kElsewhere);
        const bool elsewhere = (head.kind & kElsewhere) != 0;
        const bool ended = !out.blocks.empty() && out.blocks.back().kind == ShareBlock::Rest;
        const bool after_places = !out.blocks.empty() && out.blocks.back().kind == ShareBlock::Places;
        const bool fits = named ? !ended && (kind == ShareBlock::State) == after_places && kind <= ShareBlock::Rest
                                : kind == ShareBlock::Names && !elsewhere && head.size <= kMostNames_bytes;
        if (!fits || (elsewhere && (!changes || head.size != sizeof(WrittenBlocks::Place))))
            return damaged_share(path, fmt::format("has a block at byte {} that does not belong there", at));
        at += sizeof head;
        // These are needed now; all others are checked when they are read.
        if (!named || elsewhere) {
            std::string bytes(head.size, '\0');
            if (!read_at(file(), at, bytes.data(), bytes.size()) || hash_of(head.kind, std::as_bytes(std::span(bytes))) != head.hash)
                return damaged_share(path, fmt::format("has other bytes than were written, after byte {}", at));
            if (!named) {
                if (auto done = name_sources(out, bytes); !done) return tl::unexpected<Error>(done.error());
            } else {
                Result<Place> place = find_elsewhere(out, kind, at);
                if (!place) return tl::unexpected<Error>(place.error());
                out.blocks.push_back(*place);
            }
            named = true;
        } else {
            out.blocks.push_back({kind, 0, at, head.size, head.hash});
        }
        at += head.size;
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
    const Source& from = file.sources[place.source];
    Open again;
    if (!from.held) {
        Result<Open> opened = open_one(from.path);
        if (!opened) return tl::unexpected<Error>(opened.error());
        again = std::move(*opened);
    }
    if (!read_at(from.held ? from.held.get() : again.get(), place.offset, out.data(), place.size))
        return damaged_share(from.path, fmt::format("cannot be read at byte {}", place.offset));
    if (hash_of(static_cast<std::uint64_t>(place.kind), out) != place.hash)
        return damaged_share(from.path, fmt::format("has other bytes than were written, after byte {}", place.offset));
    return out;
}

}  // namespace meld::sim
