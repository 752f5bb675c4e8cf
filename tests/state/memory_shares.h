// A snapshot that stays in memory, of all processes that made it.
#pragma once

#include <utility>
#include <vector>

#include "runtime/sim/state/share.h"

namespace meld::sim {

// One process's share.
struct MemoryShare : ShareSink {
    Result<void> chunk(Chunk chunk) override {
        chunks.push_back(std::move(chunk));
        return {};
    }
    Result<void> rest(Block block) override {
        the_rest = std::move(block);
        return {};
    }
    std::vector<Chunk> chunks;
    Block the_rest;
};

class MemoryShares : public Shares {
  public:
    explicit MemoryShares(std::size_t processes) : shares_(processes) {}
    MemoryShare& of(int rank) { return shares_[static_cast<std::size_t>(rank)]; }

    std::size_t count() const override { return shares_.size(); }
    std::size_t chunks(std::size_t share) const override { return shares_[share].chunks.size(); }
    Result<Block> places(std::size_t share, std::size_t chunk) const override { return shares_[share].chunks[chunk].places; }
    Result<Block> state(std::size_t share, std::size_t chunk) const override { return shares_[share].chunks[chunk].state; }
    Result<Block> rest(std::size_t share) const override { return shares_[share].the_rest; }

  private:
    std::vector<MemoryShare> shares_;
};

}  // namespace meld::sim
