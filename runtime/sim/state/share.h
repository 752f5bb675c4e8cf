// A snapshot of a run between two ticks: what each process has of it, as blocks of bytes. Everything in them goes by the numbers of
// catoms and by cells, never by processes or indices, so that any number of processes can go on from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/base/error.h"

namespace meld::sim {

using Block = std::vector<std::byte>;

// Some catoms of one process: their numbers and places, and all that is kept for each.
struct Chunk {
    Block places;
    Block state;
};

// Takes the share of one process: its chunks, and then what is not a catom's.
class ShareSink {
  public:
    virtual ~ShareSink() = default;
    // At most this many catoms a chunk. In files a chunk is small beside the columns, and a column of it a long run of bytes.
    virtual std::size_t chunk_catoms() const { return std::size_t{1} << 16; }
    virtual Result<void> chunk(Chunk chunk) = 0;
    virtual Result<void> rest(Block rest) = 0;
};

// Gives the shares of all processes that made a snapshot. Errors: a block cannot be read or is damaged.
class Shares {
  public:
    virtual ~Shares() = default;
    virtual std::size_t count() const = 0;
    virtual std::size_t chunks(std::size_t share) const = 0;
    virtual Result<Block> places(std::size_t share, std::size_t chunk) const = 0;
    virtual Result<Block> state(std::size_t share, std::size_t chunk) const = 0;
    virtual Result<Block> rest(std::size_t share) const = 0;
};

}  // namespace meld::sim
