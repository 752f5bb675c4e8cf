// A snapshot of a run between two ticks: what each process has of it, as blocks of bytes. Everything in them goes by the numbers of
// catoms and by cells, never by processes or indices, so that any number of processes can go on from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/base/error.h"

namespace meld::sim {

using Block = std::vector<std::byte>;
// The bytes of a block.
using BlockView = std::span<const std::byte>;

// Of a lattice; catoms at arbitrary positions that belong together stay together.
inline constexpr std::uint32_t kMostCatomsOfAChunk = 1u << 16, kMostBodiesOfAChunk = 1u << 12;
// Where snapshots share chunks that are alike: a change costs its chunk, and two of them fit into a processor's cache while they are
// compared.
inline constexpr std::size_t kCatomsOfASmallChunk = 2048;

inline constexpr std::size_t kNoChunk = ~std::size_t{0};

// Some catoms of one process: their numbers and places, and all that is kept for each.
struct Chunk {
    BlockView places;
    BlockView state;
    // Of a lattice: which one it is of those with so many indices each, from 0 on; some may be empty.
    std::size_t number = kNoChunk;
};

// Takes the share of one process: its chunks, and then what is not a catom's. The bytes are valid while it takes them.
class ShareSink {
  public:
    virtual ~ShareSink() = default;
    // At most this many catoms a chunk. In files a chunk is small beside the columns, and a column of it a long run of bytes.
    virtual std::size_t chunk_catoms() const { return kMostCatomsOfAChunk; }
    virtual Result<void> chunk(const Chunk& chunk) = 0;
    // Takes the chunk of this number as it was in the snapshot before. Returns false if it has not got it.
    virtual bool take_as_before(std::size_t /*number*/) { return false; }
    virtual Result<void> rest(BlockView rest) = 0;
};

// Gives the shares of all processes that made a snapshot. `room` is memory for blocks that must be read first, used again and again: what
// is returned is valid until it changes, and as long as the shares. Errors: a block cannot be read or is damaged.
class Shares {
  public:
    virtual ~Shares() = default;
    virtual std::size_t count() const = 0;
    virtual std::size_t chunks(std::size_t share) const = 0;
    virtual Result<BlockView> places(std::size_t share, std::size_t chunk, Block& room) const = 0;
    virtual Result<BlockView> state(std::size_t share, std::size_t chunk, Block& room) const = 0;
    virtual Result<BlockView> rest(std::size_t share, Block& room) const = 0;
};

}  // namespace meld::sim
