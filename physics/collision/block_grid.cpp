// Sorting bodies into blocks: find the blocks that exist, count, scatter, sort each block by cell and id.
#include "physics/collision/block_grid.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"
#include "runtime/base/release_memory.h"

namespace meld::physics {

namespace {

constexpr std::size_t kSlotsPerJob = 8192;
constexpr std::size_t kBlocksPerJob = 8;
// The cell of a removed body.
constexpr std::uint16_t kNoCell = 0xffff;

std::size_t jobs_for(std::size_t count, std::size_t per_job) { return (count + per_job - 1) / per_job; }

}  // namespace

BlockCoordinates block_of(const Place& place, double block_m) {
    const auto at = [block_m](double position) {
        const double block = std::floor(position * (1 / block_m));
        return static_cast<std::int32_t>(std::clamp(block, static_cast<double>(-kFarthestBlock), static_cast<double>(kFarthestBlock)));
    };
    return {at(place.x), at(place.y), at(place.z)};
}

struct BlockGrid::Sorting {
    Buffer<std::uint64_t> key;
    Buffer<std::uint16_t> cell;
    Buffer<std::uint32_t> block;
    // The keys met by each job; a key is not repeated directly after itself.
    std::vector<std::vector<std::uint64_t>> met;
};

GridShape GridShape::fitting(double min_radius_m, double max_radius_m, double reach_m, double paths_m) {
    MELD_EXPECT(min_radius_m > 0 && max_radius_m >= min_radius_m && reach_m >= 0, "{} to {}, {}", min_radius_m, max_radius_m, reach_m);
    const double smallest = 2 * min_radius_m + reach_m;
    const double largest = 2 * max_radius_m + reach_m;
    const double coarsest = 1 << (kMaxLevels - 1);
    GridShape shape;
    shape.cell_m = std::max(smallest, largest / coarsest);
    // Doubled, so that the blocks seldom change with the speed of the fastest body.
    while (shape.block_m() / 2 < largest + paths_m) shape.cell_m *= 2;
    while (shape.cell_m * (1 << (shape.levels - 1)) < largest && shape.levels < kMaxLevels) ++shape.levels;
    // The colours of the solver rely on this: a pair reaches into the next block at most.
    MELD_ENSURE(largest <= shape.cell_m * (1 << (shape.levels - 1)) * (1 + 1e-12), "{} in cells of {}", largest, shape.cell_m);
    return shape;
}

Vec3 BlockGrid::origin(const Block& block) const {
    const BlockCoordinates c = unpack(block.key);
    return shape_.block_m() * Vec3{static_cast<double>(c.x), static_cast<double>(c.y), static_cast<double>(c.z)};
}

Result<void> BlockGrid::build(Bodies& bodies, const GridShape& shape, double reach_m, Workers& workers, Buffer<std::uint32_t>& order) {
    const GridShape former = std::exchange(shape_, shape);
    Sorting sorting;
    if (auto located = locate(bodies, reach_m, workers, sorting); !located) {
        shape_ = former;
        return located;
    }
    std::vector<std::uint64_t> keys;
    for (const auto& met : sorting.met) keys.insert(keys.end(), met.begin(), met.end());
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    make_blocks(keys);
    assign(workers, sorting, order);
    rows_.resize(blocks_.size() * kRowEntries);
    cells_.resize(order.size());
    std::vector<std::vector<std::uint32_t>> scratch(static_cast<std::size_t>(workers.threads()));
    workers.run(jobs_for(blocks_.size(), kBlocksPerJob), [&](int worker, std::size_t job) {
        const std::size_t end = std::min(blocks_.size(), (job + 1) * kBlocksPerJob);
        for (std::size_t b = job * kBlocksPerJob; b < end; ++b)
            sort_block(bodies, sorting, static_cast<std::uint32_t>(b), order, scratch[static_cast<std::size_t>(worker)]);
    });
    link_blocks(workers);
    sorting = {};
    release_memory(scratch);
    bodies.permute(order, workers, blocks_.size());
    return {};
}

// Key and cell of each body, and the keys met.
Result<void> BlockGrid::locate(const Bodies& bodies, double reach_m, Workers& workers, Sorting& sorting) const {
    const std::size_t count = bodies.count();
    sorting.key.resize(count);
    sorting.cell.resize(count);
    sorting.met.resize(jobs_for(count, kSlotsPerJob));
    const double blocks_per_m = 1 / shape_.block_m(), cells_per_m = 1 / shape_.cell_m, block_m = shape_.block_m();
    constexpr std::uint32_t kNobody = 0xffffffff;
    std::atomic<std::uint32_t> lost{kNobody};
    workers.run(sorting.met.size(), [&](int, std::size_t job) {
        std::uint64_t last = 0;
        const std::size_t end = std::min(count, (job + 1) * kSlotsPerJob);
        for (std::size_t i = job * kSlotsPerJob; i < end; ++i) {
            sorting.cell[i] = kNoCell;
            if (bodies.properties[i].flags & kRemoved) continue;
            const Place& p = bodies.place[i];
            const double x = std::floor(p.x * blocks_per_m), y = std::floor(p.y * blocks_per_m), z = std::floor(p.z * blocks_per_m);
            if (!(std::abs(x) <= kFarthestBlock && std::abs(y) <= kFarthestBlock && std::abs(z) <= kFarthestBlock)) {
                std::uint32_t seen = lost.load();
                while (bodies.properties[i].id < seen && !lost.compare_exchange_weak(seen, bodies.properties[i].id)) {
                }
                continue;
            }
            int level = 0;
            while (level + 1 < shape_.levels && 2 * p.radius + reach_m > shape_.cell_m * (1 << level)) ++level;
            const auto cell = [&](double position, double block) {
                const int fine = static_cast<int>((position - block * block_m) * cells_per_m);
                return std::clamp(fine, 0, kBlockCells - 1) >> level;
            };
            const int side = cells_a_side(level);
            sorting.cell[i] = static_cast<std::uint16_t>(first_cell(level) + (cell(p.z, z) * side + cell(p.y, y)) * side + cell(p.x, x));
            const std::uint64_t key = pack({static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)});
            sorting.key[i] = key;
            if (key != last) sorting.met[job].push_back(key);
            last = key;
        }
    });
    if (lost != kNobody) {
        const Place& p = bodies.place[bodies.slot(lost)];
        return fail(fmt::format("body {} is at ({}, {}, {}), which is not within {:.3g} m of the origin", lost.load(), p.x, p.y, p.z,
                                kFarthestBlock * block_m),
                    "Check its velocity and the forces on it, or take a shorter step");
    }
    return {};
}

void BlockGrid::restore(const GridShape& shape, std::span<const std::pair<std::uint64_t, std::uint32_t>> blocks, Workers& workers) {
    shape_ = shape;
    std::vector<std::uint64_t> keys;
    for (const auto& [key, count] : blocks) keys.push_back(key);
    make_blocks(keys);
    std::uint32_t first = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        blocks_[b].first = first;
        blocks_[b].count = blocks[b].second;
        first += blocks_[b].count;
    }
    link_blocks(workers);
}

// The blocks in the order of their keys, and the table that finds them.
void BlockGrid::make_blocks(std::span<const std::uint64_t> keys) {
    std::size_t size = 16;
    while (size < 2 * keys.size()) size *= 2;
    table_.assign(size, kNoBlock);
    blocks_.resize(keys.size());
    for (std::size_t b = 0; b < keys.size(); ++b) {
        blocks_[b].key = keys[b];
        std::size_t at = mix64(keys[b]) & (size - 1);
        while (table_[at] != kNoBlock) at = (at + 1) & (size - 1);
        table_[at] = static_cast<std::uint32_t>(b);
    }
    MELD_ENSURE(std::is_sorted(blocks_.begin(), blocks_.end(), [](const Block& a, const Block& b) { return a.key < b.key; }));
}

std::uint32_t BlockGrid::find(std::uint64_t key) const {
    if (table_.empty()) return kNoBlock;
    std::size_t at = mix64(key) & (table_.size() - 1);
    while (table_[at] != kNoBlock && blocks_[table_[at]].key != key) at = (at + 1) & (table_.size() - 1);
    return table_[at];
}

std::uint32_t BlockGrid::block_with(std::uint32_t slot) const {
    const auto after =
        std::upper_bound(blocks_.begin(), blocks_.end(), slot, [](std::uint32_t value, const Block& block) { return value < block.first; });
    if (after == blocks_.begin() || slot - std::prev(after)->first >= std::prev(after)->count) return kNoBlock;
    return static_cast<std::uint32_t>(after - blocks_.begin()) - 1;
}

void BlockGrid::link_blocks(Workers& workers) {
    workers.run(jobs_for(blocks_.size(), kBlocksPerJob), [&](int, std::size_t job) {
        const std::size_t end = std::min(blocks_.size(), (job + 1) * kBlocksPerJob);
        for (std::size_t b = job * kBlocksPerJob; b < end; ++b) {
            const BlockCoordinates c = unpack(blocks_[b].key);
            for (int i = 0; i < 27; ++i)
                blocks_[b].neighbours[static_cast<std::size_t>(i)] = find(pack({c.x + i % 3 - 1, c.y + i / 3 % 3 - 1, c.z + i / 9 - 1}));
        }
    });
}

// Counts the bodies of each block and scatters their slots; the order within a block is arbitrary until it is sorted.
void BlockGrid::assign(Workers& workers, Sorting& sorting, Buffer<std::uint32_t>& order) {
    const std::size_t count = sorting.key.size();
    sorting.block.resize(count);
    std::vector<std::atomic<std::uint32_t>> next(blocks_.size() + 1);
    workers.run(sorting.met.size(), [&](int, std::size_t job) {
        std::uint64_t last = 0;
        std::uint32_t block = kNoBlock;
        std::size_t met = 0;
        const std::size_t end = std::min(count, (job + 1) * kSlotsPerJob);
        for (std::size_t i = job * kSlotsPerJob; i < end; ++i) {
            sorting.block[i] = kNoBlock;
            if (sorting.cell[i] == kNoCell) continue;
            if (met == 0 || sorting.key[i] != last) {
                last = sorting.key[i];
                block = find(last);
                MELD_ASSERT(block != kNoBlock, "key {}", last);
                ++met;
            }
            sorting.block[i] = block;
            next[block].fetch_add(1, std::memory_order_relaxed);
        }
    });
    std::uint32_t first = 0;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        blocks_[b].first = first;
        blocks_[b].count = next[b].load(std::memory_order_relaxed);
        next[b].store(first, std::memory_order_relaxed);
        first += blocks_[b].count;
    }
    MELD_ASSERT(first <= count, "{} of {} bodies in blocks", first, count);
    order.resize(first);
    workers.run(sorting.met.size(), [&](int, std::size_t job) {
        const std::size_t end = std::min(count, (job + 1) * kSlotsPerJob);
        for (std::size_t i = job * kSlotsPerJob; i < end; ++i)
            if (sorting.block[i] != kNoBlock)
                order[next[sorting.block[i]].fetch_add(1, std::memory_order_relaxed)] = static_cast<std::uint32_t>(i);
    });
}

// A counting sort by cell, then the few bodies of each cell by id.
void BlockGrid::sort_block(const Bodies& bodies, const Sorting& sorting, std::uint32_t block, std::span<std::uint32_t> order,
                           std::vector<std::uint32_t>& scratch) {
    const std::span<std::uint32_t> mine = order.subspan(blocks_[block].first, blocks_[block].count);
    std::array<std::uint32_t, kCellsOfBlock + 1> start{};
    for (const std::uint32_t slot : mine) ++start[sorting.cell[slot] + 1u];
    for (std::size_t c = 0; c < kCellsOfBlock; ++c) start[c + 1] += start[c];
    for (int level = 0; level < kMaxLevels; ++level) {
        const int side = cells_a_side(level);
        for (int row = 0; row < side * side; ++row)
            rows_[block * kRowEntries + static_cast<std::size_t>(first_row(level) + row)] =
                start[static_cast<std::size_t>(first_cell(level) + row * side)];
    }
    rows_[block * kRowEntries + kRowsOfBlock] = blocks_[block].count;
    MELD_ASSERT(start[kCellsOfBlock] == blocks_[block].count, "block {}: {} of {}", block, start[kCellsOfBlock], blocks_[block].count);

    for (std::size_t c = 0; c < kCellsOfBlock; ++c)
        std::fill(&cells_[blocks_[block].first] + start[c], &cells_[blocks_[block].first] + start[c + 1], static_cast<std::uint16_t>(c));
    scratch.assign(mine.begin(), mine.end());
    const auto by_id = [&](std::uint32_t a, std::uint32_t b) { return bodies.properties[a].id < bodies.properties[b].id; };
    std::array<std::uint32_t, kCellsOfBlock + 1> next = start;
    for (const std::uint32_t slot : scratch) mine[next[sorting.cell[slot]]++] = slot;
    for (std::size_t c = 0; c < kCellsOfBlock; ++c)
        if (start[c + 1] - start[c] > 1) std::sort(mine.begin() + start[c], mine.begin() + start[c + 1], by_id);
}

void BlockGrid::forget_cells() {
    release_memory(rows_);
    release_memory(cells_);
}

std::size_t BlockGrid::bytes() const {
    return blocks_.capacity() * sizeof(Block) + table_.capacity() * sizeof(table_[0]) + rows_.capacity() * sizeof(rows_[0]) +
           cells_.capacity() * sizeof(cells_[0]);
}

}  // namespace meld::physics
