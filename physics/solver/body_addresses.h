// Bodies in a snapshot of a block's contacts: by their places in the blocks around, which are the same on every subdomain.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "physics/collision/block_grid.h"
#include "runtime/base/assert.h"

namespace meld::physics {

// A body as the neighbour of a block in which it is, and its place there.
inline constexpr int kIndexBits = 27;

class BodyAddresses {
  public:
    BodyAddresses(const BlockGrid& grid, std::uint32_t block) : blocks_(grid.blocks()), around_(blocks_[block].neighbours) {}

    std::uint32_t address(std::uint32_t slot) {
        if (!in(last_, slot))
            for (last_ = 0; !in(last_, slot); ++last_) MELD_CHECK(last_ + 1 < around_.size(), "slot {} is in no block around", slot);
        return static_cast<std::uint32_t>(last_) << kIndexBits | (slot - blocks_[around_[last_]].first);
    }
    // kNoSlot if there is no such body.
    std::uint32_t slot(std::uint32_t address) const {
        const std::size_t neighbour = address >> kIndexBits;
        const std::uint32_t index = address & ((1u << kIndexBits) - 1);
        if (neighbour >= around_.size() || around_[neighbour] == kNoBlock || index >= blocks_[around_[neighbour]].count) return kNoSlot;
        return blocks_[around_[neighbour]].first + index;
    }

  private:
    static constexpr std::size_t kItself = 13;
    bool in(std::size_t neighbour, std::uint32_t slot) const {
        const std::uint32_t block = around_[neighbour];
        return block != kNoBlock && slot - blocks_[block].first < blocks_[block].count;
    }
    std::span<const Block> blocks_;
    const std::array<std::uint32_t, 27>& around_;
    std::size_t last_ = kItself;
};

}  // namespace meld::physics
