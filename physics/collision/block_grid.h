// The sparse grid of blocks: space divided into blocks of 8x8x8 cells, of which only those with bodies exist.
//
// Bodies are sorted by block, then level, cell and id, so a block's bodies are one range of slots and the order depends only on the world.
// A cell of level k has 2^k times the edge of the smallest; a body belongs to the level whose cells are at least its diameter plus the
// reach. Blocks are coloured by the parity of their coordinates: two blocks of one colour touch disjoint bodies, as long as pairs reach at
// most half a block.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "physics/bodies/bodies.h"
#include "physics/bodies/stage.h"
#include "runtime/base/assert.h"
#include "runtime/base/error.h"
#include "runtime/base/process/parallel_for.h"

namespace meld::physics {

inline constexpr int kBlockCells = 8;
inline constexpr int kMaxLevels = 3;
inline constexpr std::uint32_t kNoBlock = 0xffffffff;
// Cells of all levels in a block, and rows of them along x.
inline constexpr int kCellsOfBlock = 512 + 64 + 8;
inline constexpr int kRowsOfBlock = 64 + 16 + 4;

struct BlockCoordinates {
    std::int32_t x, y, z;
    bool operator==(const BlockCoordinates&) const = default;
};

// Coordinates packed into a word that orders blocks by z, y, x. Each lies in -kFarthestBlock .. kFarthestBlock.
inline constexpr std::int32_t kFarthestBlock = (1 << 20) - 2;
constexpr std::uint64_t pack(BlockCoordinates c) {
    // The blocks around the farthest ones are looked up too.
    MELD_EXPECT(c.x >= -kFarthestBlock - 1 && c.x <= kFarthestBlock + 1 && c.y >= -kFarthestBlock - 1 && c.y <= kFarthestBlock + 1 &&
                    c.z >= -kFarthestBlock - 1 && c.z <= kFarthestBlock + 1,
                "block {} {} {}", c.x, c.y, c.z);
    const auto biased = [](std::int32_t value) { return static_cast<std::uint64_t>(value + (1 << 20)); };
    return biased(c.z) << 42 | biased(c.y) << 21 | biased(c.x);
}
constexpr BlockCoordinates unpack(std::uint64_t key) {
    const auto part = [key](int shift) { return static_cast<std::int32_t>(key >> shift & 0x1fffff) - (1 << 20); };
    return {part(0), part(21), part(42)};
}
constexpr int colour_of(BlockCoordinates c) { return (c.x & 1) | (c.y & 1) << 1 | (c.z & 1) << 2; }

struct Block {
    std::uint64_t key;
    // Its bodies are the slots first .. first + count - 1.
    std::uint32_t first;
    std::uint32_t count;
    // By (dz + 1) * 9 + (dy + 1) * 3 + dx + 1; kNoBlock where there is none. The middle one is the block itself.
    std::array<std::uint32_t, 27> neighbours;
};

struct GridShape {
    double cell_m = 1;
    int levels = 1;

    double block_m() const { return cell_m * kBlockCells; }
    // Cells that fit bodies of these radii, for pairs up to `reach_m` apart (surface to surface). Bodies more than four times larger than
    // the smallest make all cells larger, and so do bodies of which two may travel paths_m together before the next search: all pairs lie
    // within half a block.
    static GridShape fitting(double min_radius_m, double max_radius_m, double reach_m, double paths_m = 0);
};

// The block of a position; one that is too far away gets some block, and the next sorting reports it.
BlockCoordinates block_of(const Place& place, double block_m);

class BlockGrid {
  public:
    // Sorts the bodies into blocks; those flagged kRemoved are dropped. The error names a body whose position is not a number or too far
    // away; nothing has changed then. `order` receives the former slot of each body.
    Result<void> build(Bodies& bodies, const GridShape& shape, double reach_m, Workers& workers, Buffer<std::uint32_t>& order);

    // Makes the blocks of bodies that are sorted already: the key of each and how many bodies it has, sorted by key.
    void restore(const GridShape& shape, std::span<const std::pair<std::uint64_t, std::uint32_t>> blocks, Workers& workers);

    const GridShape& shape() const { return shape_; }
    std::span<const Block> blocks() const { return blocks_; }
    // The index of the block with this key, or kNoBlock.
    std::uint32_t find(std::uint64_t key) const;
    // The index of the block whose bodies include the one in this slot; kNoBlock if it was added after the blocks were made.
    std::uint32_t block_with(std::uint32_t slot) const;

    // First slot of each row of cells of a block, counted from the block's first; kRowsOfBlock + 1 entries.
    std::span<const std::uint32_t> rows(std::uint32_t block) const {
        MELD_EXPECT(block < blocks_.size() && rows_.size() == blocks_.size() * kRowEntries, "block {} of {}", block, blocks_.size());
        return {&rows_[block * kRowEntries], kRowEntries};
    }
    std::span<const std::uint16_t> cells() const { return cells_; }
    // Rows and cells are used only by the search for pairs; this frees them.
    void forget_cells();

    Vec3 origin(const Block& block) const;
    std::size_t bytes() const;

  private:
    static constexpr std::size_t kRowEntries = kRowsOfBlock + 1;
    struct Sorting;

    Result<void> locate(const Bodies& bodies, double reach_m, Workers& workers, Sorting& sorting) const;
    // From their keys, sorted.
    void make_blocks(std::span<const std::uint64_t> keys);
    void link_blocks(Workers& workers);
    void assign(Workers& workers, Sorting& sorting, Buffer<std::uint32_t>& order);
    void sort_block(const Bodies& bodies, const Sorting& sorting, std::uint32_t block, std::span<std::uint32_t> order,
                    std::vector<std::uint32_t>& scratch);

    GridShape shape_;
    std::vector<Block> blocks_;
    std::vector<std::uint32_t> table_;
    Buffer<std::uint32_t> rows_;
    Buffer<std::uint16_t> cells_;
};

// First cell and first row of a level within a block, and its number of cells per side.
constexpr int cells_a_side(int level) { return kBlockCells >> level; }
constexpr int first_cell(int level) { return level == 0 ? 0 : level == 1 ? 512 : 576; }
constexpr int first_row(int level) { return level == 0 ? 0 : level == 1 ? 64 : 80; }

}  // namespace meld::physics
