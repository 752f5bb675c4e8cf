// A snapshot that stays in memory, of all processes that made it.
#pragma once

#include <vector>

#include "runtime/sim/state/share.h"

namespace meld::sim {

// One process's share.
struct MemoryShare : ShareSink {
    struct Kept {
        Block places, state;
    };
    Result<void> chunk(const Chunk& chunk) override {
        chunks.push_back({{chunk.places.begin(), chunk.places.end()}, {chunk.state.begin(), chunk.state.end()}});
        return {};
    }
    Result<void> rest(BlockView rest) override {
        the_rest.assign(rest.begin(), rest.end());
        return {};
    }
    std::vector<Kept> chunks;
    Block the_rest;
};

class MemoryShares : public Shares {
  public:
    explicit MemoryShares(std::size_t processes) : shares_(processes) {}
    MemoryShare& of(int rank) { return shares_[static_cast<std::size_t>(rank)]; }

    std::size_t count() const override { return shares_.size(); }
    std::size_t chunks(std::size_t share) const override { return shares_[share].chunks.size(); }
    Result<BlockView> places(std::size_t share, std::size_t chunk, Block&) const override { return shares_[share].chunks[chunk].places; }
    Result<BlockView> state(std::size_t share, std::size_t chunk, Block&) const override { return shares_[share].chunks[chunk].state; }
    Result<BlockView> rest(std::size_t share, Block&) const override { return shares_[share].the_rest; }

  private:
    std::vector<MemoryShare> shares_;
};

}  // namespace meld::sim
