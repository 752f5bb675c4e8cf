// The pairs of bodies that a block owns: each body of the block with those of its own cell and the 13 cells ahead, and with
// all cells around it in coarser levels. So each pair of the world is found in exactly one block, once, in an order that
// depends on the world alone.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/block_grid.h"
#include "physics/bodies.h"

namespace meld::physics {

// One thread's workspace; `search` overwrites what it holds.
class PairSearch {
  public:
    // Finds the pairs of `block` whose surfaces are less than `reach_m` apart, except those of two fixed bodies. The grid's
    // cells must be there. Pairs are indices into slots().
    void search(const BlockGrid& grid, const Bodies& bodies, std::uint32_t block, double reach_m);

    std::span<const BodyPair> pairs() const { return pairs_; }
    // The bodies of the block and of the cells around it.
    std::span<const std::uint32_t> slots() const { return slots_; }

  private:
    static constexpr int kPaddedCells = 1000 + 216 + 64;

    void gather_level(const BlockGrid& grid, const Bodies& bodies, const Block& block, int level);
    void add_range(const Bodies& bodies, std::uint32_t begin, std::uint32_t end, Vec3 origin);
    void pair_level(int level);
    void pair_with_coarser(int level, int coarser, double coarse_cells_per_m);
    void test(std::uint32_t i, std::uint32_t begin, std::uint32_t end);

    std::vector<BodyPair> pairs_;
    std::vector<std::uint32_t> slots_;
    // Relative to the block's corner; radius with half the reach; whether it is fixed.
    std::vector<float> x_, y_, z_, radius_;
    std::vector<std::uint8_t> fixed_;
    // Where each padded cell of each level begins.
    std::array<std::uint32_t, kPaddedCells + kMaxLevels> start_{};
    float half_reach_ = 0;
};

}  // namespace meld::physics
