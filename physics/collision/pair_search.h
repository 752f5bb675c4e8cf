// The pairs of bodies that a block owns: each body of the block with those of its own cell and the 13 cells ahead, and with all cells
// around it in coarser levels. So each pair of the world is found once, in exactly one block, in an order that depends only on the world.
//
// A fast body meets others far from where it is: its pairs are those with all bodies that it could meet within a given time. They belong to
// the block with the lower key and lie within half a block of it, so blocks of one colour still share no body.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "physics/bodies/bodies.h"
#include "physics/collision/block_grid.h"

namespace meld::physics {

// One thread's workspace; `search` overwrites what it holds.
class PairSearch {
  public:
    struct Reach {
        // Search for pairs whose surfaces are less than this apart,
        double apart_m = 0;
        // and for pairs that may meet within ahead_s seconds if one of them is fast: if it travels farther than slow_m in this time,
        // relative to a moving frame. 0: nothing is fast.
        double ahead_s = 0, slow_m = 0;
        Vec3 frame_m_s = {};
    };
    // Finds the pairs of `block`, except those of two fixed bodies. The grid must have its cells, and no two bodies that may meet may be
    // farther apart than half a block (GridShape::fitting). Pairs are indices into slots().
    void search(const BlockGrid& grid, const Bodies& bodies, std::uint32_t block, const Reach& reach);

    std::span<const BodyPair> pairs() const { return pairs_; }
    // Pairs from this index on are of fast bodies.
    std::size_t first_fast() const { return first_fast_; }
    // The bodies of the block and of the cells around it, then those that only fast bodies reach.
    std::span<const std::uint32_t> slots() const { return slots_; }

  private:
    static constexpr int kPaddedCells = 1000 + 216 + 64;

    void gather_level(const BlockGrid& grid, const Bodies& bodies, const Block& block, int level);
    void add_range(const Bodies& bodies, std::uint32_t begin, std::uint32_t end, Vec3 origin);
    void pair_level(int level);
    void pair_with_coarser(int level, int coarser, double coarse_cells_per_m);
    void test(std::uint32_t i, std::uint32_t begin, std::uint32_t end);
    void pair_fast(const BlockGrid& grid, const Bodies& bodies, const Block& block);
    void test_fast(const Bodies& bodies, std::uint32_t a, std::uint32_t b);
    // How far a body travels, m.
    float path_of(const Bodies& bodies, std::uint32_t slot) const;
    bool is_fast(const Bodies& bodies, std::uint32_t slot) const {
        return reach_.ahead_s > 0 && path_of(bodies, slot) > static_cast<float>(reach_.slow_m);
    }
    std::uint32_t index_of(std::uint32_t slot);

    std::vector<BodyPair> pairs_;
    std::size_t first_fast_ = 0;
    std::vector<std::uint32_t> slots_;
    // Relative to the block's corner; radius with half the reach; whether it is fixed, whether it is fast.
    std::vector<float> x_, y_, z_, radius_;
    static constexpr std::uint8_t kIsFixed = 1, kIsFast = 2;
    std::vector<std::uint8_t> kinds_;
    // Indices into slots_, filled for blocks with pairs of fast bodies.
    std::unordered_map<std::uint32_t, std::uint32_t> indices_;
    std::vector<std::uint32_t> fast_here_, fast_there_;
    Reach reach_;
    double block_m_ = 0;
    // Where each padded cell of each level begins.
    std::array<std::uint32_t, kPaddedCells + kMaxLevels> start_{};
    float half_reach_ = 0;
};

}  // namespace meld::physics
