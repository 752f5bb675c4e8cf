// A share of a snapshot in a file: blocks one after the other, each with its length and a hash of its bytes, so that a file that ends
// too early or has other bytes than were written is refused. Of a share that holds changes, a block that is as in an earlier share says
// instead in which file and where it is; these files are in the same folder.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/files/output_file.h"
#include "runtime/sim/state/share.h"

namespace meld::sim {

// Two of each chunk, and one at the end. Names, if there are any, come first: of the files in which other blocks are.
enum class ShareBlock : std::uint64_t { Places, State, Rest, Names };

// Where the blocks of a share are, by their content: the next share refers to those that are as they were.
struct WrittenBlocks {
    struct Place {
        std::uint64_t file = 0;  // Of `files`.
        std::uint64_t offset = 0, size = 0, hash = 0;
    };
    using Content = std::pair<std::uint64_t, std::uint64_t>;
    // Of a chunk whose number is known, its two blocks; the bytes of those that are shorter than what says where they are.
    struct Known {
        Content content = {};
        std::vector<std::byte> bytes = {};
    };
    std::vector<std::string> files = {};  // Names, without folder.
    std::map<Content, Place> blocks = {};
    std::map<std::size_t, std::array<Known, 2>> chunks = {};
};

// Writes chunk by chunk; the file is there, and safe from a failure of the machine, when close() has returned well.
class ShareWriter : public ShareSink {
  public:
    // Errors: the file cannot be made.
    static Result<std::unique_ptr<ShareWriter>> create(const std::string& path);
    // The same with smaller chunks, whose places it notes: of a whole share if there are none before, else with what is not in those.
    static Result<std::unique_ptr<ShareWriter>> create(const std::string& path, const WrittenBlocks& before);
    std::size_t chunk_catoms() const override;
    Result<void> chunk(const Chunk& chunk) override;
    bool take_as_before(std::size_t number) override;
    Result<void> rest(BlockView rest) override;
    // Takes so much space on the disk in advance. Errors: there is not so much.
    Result<void> reserve(std::uint64_t bytes);
    std::uint64_t size() const { return file_.size(); }
    // All blocks of this share, wherever they are.
    WrittenBlocks take_written() { return std::move(*written_); }
    Result<void> close();

  private:
    explicit ShareWriter(OutputFile file) : file_(std::move(file)) {}
    WrittenBlocks::Known write(ShareBlock kind, BlockView block);
    void write_elsewhere(std::uint64_t kind, const WrittenBlocks::Place& place);
    void write_as_it_is(std::uint64_t kind, BlockView block, std::uint64_t hash);

    OutputFile file_;
    const WrittenBlocks* before_ = nullptr;
    std::optional<WrittenBlocks> written_;
};

// The files of all processes that made a snapshot, by their numbers. Blocks are read and checked when they are asked for; also when the run
// that made them has removed the files meanwhile, if it had no more than kMostHeld processes.
class ShareFiles : public Shares {
  public:
    // A process may have some thousand files open, and needs some for itself.
    static constexpr std::size_t kMostHeld = 500;

    // Errors: a file is missing or none of ours, or has no whole number of blocks.
    static Result<ShareFiles> open(const std::vector<std::string>& paths);

    // It refers to no other file.
    bool is_whole(std::size_t share) const { return files_[share].sources.size() == 1; }
    // Reads everything once; the first block that is damaged is the error.
    Result<void> check() const;
    std::size_t count() const override { return files_.size(); }
    std::size_t chunks(std::size_t share) const override { return files_[share].blocks.size() / 2; }
    Result<BlockView> places(std::size_t share, std::size_t chunk, Block& room) const override { return read(share, 2 * chunk, room); }
    Result<BlockView> state(std::size_t share, std::size_t chunk, Block& room) const override { return read(share, 2 * chunk + 1, room); }
    Result<BlockView> rest(std::size_t share, Block& room) const override { return read(share, files_[share].blocks.size() - 1, room); }

  private:
    struct Place {
        ShareBlock kind = ShareBlock::Rest;
        std::size_t source = 0;
        std::uint64_t offset = 0, size = 0, hash = 0;
    };
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    using Open = std::unique_ptr<std::FILE, Close>;
    // A file in which blocks are.
    struct Source {
        std::string path;
        Open held = {};  // None of so many that a process cannot hold them all: it is opened again each time.
        std::uint64_t size = 0;
    };
    struct File {
        std::vector<Source> sources;  // The share itself, and then those to which it may refer.
        std::vector<Place> blocks;
    };
    static Result<Open> open_one(const std::string& path);
    static Result<Source> source(const std::string& path);
    static Result<File> index(const std::string& path);
    static Result<void> name_sources(File& file, const std::string& names);
    static Result<Place> find_elsewhere(File& file, ShareBlock kind, std::uint64_t offset);
    Result<BlockView> read(std::size_t share, std::size_t block, Block& room) const;

    std::vector<File> files_;
    std::uint64_t largest_ = 0;  // The bytes of the largest block.
};

}  // namespace meld::sim
