// The search works on a copy of the block and a border one cell wide, in which the cells of a row are contiguous, so the 13 cells ahead are
// five ranges.
#include "physics/collision/pair_search.h"
#include "runtime/base/assert.h"

#include <algorithm>

namespace meld::physics {

namespace {

constexpr int padded_side(int level) { return cells_a_side(level) + 2; }
// A level's starts have one entry more than it has cells.
constexpr std::size_t first_start(int level) { return level == 0 ? 0 : level == 1 ? 1001 : 1001 + 217; }

}  // namespace

void PairSearch::search(const BlockGrid& grid, const Bodies& bodies, std::uint32_t block_index, const Reach& reach) {
    MELD_EXPECT(block_index < grid.blocks().size() && reach.apart_m >= 0 && reach.ahead_s >= 0, "block {}, reach {}", block_index,
                reach.apart_m);
    MELD_EXPECT(grid.cells().size() == bodies.count(), "cells of {} of {} bodies", grid.cells().size(), bodies.count());
    const Block& block = grid.blocks()[block_index];
    pairs_.clear();
    slots_.clear(), x_.clear(), y_.clear(), z_.clear(), radius_.clear(), kinds_.clear();
    reach_ = reach, block_m_ = grid.shape().block_m();
    half_reach_ = static_cast<float>(reach.apart_m / 2);
    const int levels = grid.shape().levels;
    for (int level = 0; level < levels; ++level) gather_level(grid, bodies, block, level);
    for (int level = 0; level < levels; ++level) {
        pair_level(level);
        for (int coarser = level + 1; coarser < levels; ++coarser)
            pair_with_coarser(level, coarser, 1 / (grid.shape().cell_m * (1 << coarser)));
    }
    first_fast_ = pairs_.size();
    if (reach.ahead_s > 0) pair_fast(grid, bodies, block);
}

float PairSearch::path_of(const Bodies& bodies, std::uint32_t slot) const {
    return static_cast<float>(reach_.ahead_s * length(velocity_of(bodies.velocity[slot]) - reach_.frame_m_s));
}

// A pair in two blocks is tested by the block with the lower key.
void PairSearch::pair_fast(const BlockGrid& grid, const Bodies& bodies, const Block& block) {
    indices_.clear();
    const auto list_fast = [&](const Block& of, std::vector<std::uint32_t>& fast) {
        fast.clear();
        for (std::uint32_t slot = of.first; slot < of.first + of.count; ++slot)
            if (is_fast(bodies, slot)) fast.push_back(slot);
    };
    const std::uint32_t end = block.first + block.count;
    list_fast(block, fast_here_);
    for (const std::uint32_t a : fast_here_)
        for (std::uint32_t b = block.first; b < end; ++b)
            if (b > a || (b < a && !is_fast(bodies, b))) test_fast(bodies, a, b);
    for (const std::uint32_t neighbour : block.neighbours) {
        if (neighbour == kNoBlock || grid.blocks()[neighbour].key <= block.key) continue;
        const Block& there = grid.blocks()[neighbour];
        for (const std::uint32_t a : fast_here_)
            for (std::uint32_t b = there.first; b < there.first + there.count; ++b) test_fast(bodies, a, b);
        list_fast(there, fast_there_);
        if (fast_there_.empty()) continue;
        for (std::uint32_t a = block.first; a < end; ++a) {
            if (is_fast(bodies, a)) continue;
            for (const std::uint32_t b : fast_there_) test_fast(bodies, a, b);
        }
    }
}

void PairSearch::test_fast(const Bodies& bodies, std::uint32_t a, std::uint32_t b) {
    const Place &first = bodies.place[a], &second = bodies.place[b];
    const Vec3 apart{second.x - first.x, second.y - first.y, second.z - first.z};
    // Only a body faster than the world allows could travel farther.
    const double farthest = block_m_ / 2, square = dot(apart, apart);
    if (square >= farthest * farthest) return;
    const double paths = static_cast<double>(path_of(bodies, a)) + static_cast<double>(path_of(bodies, b));
    const double reach = std::min(first.radius + second.radius + reach_.apart_m + paths, farthest);
    if (square >= reach * reach || (bodies.properties[a].flags & bodies.properties[b].flags & kFixed) != 0) return;
    pairs_.push_back({index_of(a), index_of(b)});
}

std::uint32_t PairSearch::index_of(std::uint32_t slot) {
    if (indices_.empty())
        for (std::uint32_t i = 0; i < slots_.size(); ++i) indices_.emplace(slots_[i], i);
    const auto [at, made] = indices_.try_emplace(slot, static_cast<std::uint32_t>(slots_.size()));
    if (made) slots_.push_back(slot);
    return at->second;
}

void PairSearch::add_range(const Bodies& bodies, std::uint32_t begin, std::uint32_t end, Vec3 origin) {
    for (std::uint32_t slot = begin; slot < end; ++slot) {
        const Place& p = bodies.place[slot];
        slots_.push_back(slot);
        x_.push_back(static_cast<float>(p.x - origin.x));
        y_.push_back(static_cast<float>(p.y - origin.y));
        z_.push_back(static_cast<float>(p.z - origin.z));
        radius_.push_back(static_cast<float>(p.radius) + half_reach_);
        kinds_.push_back(
            static_cast<std::uint8_t>((bodies.properties[slot].flags & kFixed ? kIsFixed : 0) | (is_fast(bodies, slot) ? kIsFast : 0)));
    }
}

void PairSearch::gather_level(const BlockGrid& grid, const Bodies& bodies, const Block& block, int level) {
    const int side = cells_a_side(level), padded = padded_side(level);
    const Vec3 origin = grid.origin(block);
    const std::span<const std::uint16_t> cells = grid.cells();
    std::uint32_t* start = &start_[first_start(level)];
    // Which neighbour along one axis, and which of its cells.
    const auto split = [side](int padded_cell) {
        struct Split {
            int neighbour, cell;
        };
        if (padded_cell == 0) return Split{0, side - 1};
        if (padded_cell == side + 1) return Split{2, 0};
        return Split{1, padded_cell - 1};
    };
    for (int row = 0; row < padded * padded; ++row) {
        const auto [dz, cz] = split(row / padded);
        const auto [dy, cy] = split(row % padded);
        const int row_cell = (cz * side + cy) * side;
        std::uint32_t* row_start = start + row * padded;
        for (int dx = 0; dx < 3; ++dx) {
            const int first_padded = dx == 0 ? 0 : dx == 1 ? 1 : side + 1;
            const int count = dx == 1 ? side : 1;
            const int first = first_cell(level) + row_cell + (dx == 0 ? side - 1 : 0);
            const std::uint32_t neighbour = block.neighbours[static_cast<std::size_t>(dz * 9 + dy * 3 + dx)];
            const std::uint32_t base = static_cast<std::uint32_t>(slots_.size());
            if (neighbour == kNoBlock) {
                std::fill_n(row_start + first_padded, count, base);
                continue;
            }
            const std::uint32_t block_first = grid.blocks()[neighbour].first;
            const std::size_t row_index = static_cast<std::size_t>(first_row(level) + cz * side + cy);
            std::uint32_t slot = block_first + grid.rows(neighbour)[row_index];
            const std::uint32_t row_end = block_first + grid.rows(neighbour)[row_index + 1];
            while (slot < row_end && cells[slot] < first) ++slot;
            const std::uint32_t begin = slot;
            for (int c = 0; c < count; ++c) {
                row_start[first_padded + c] = base + slot - begin;
                while (slot < row_end && cells[slot] == first + c) ++slot;
            }
            add_range(bodies, begin, slot, origin);
        }
    }
    start[padded * padded * padded] = static_cast<std::uint32_t>(slots_.size());
    MELD_ENSURE(std::is_sorted(start, start + padded * padded * padded + 1), "level {}", level);
}

void PairSearch::test(std::uint32_t i, std::uint32_t begin, std::uint32_t end) {
    const float x = x_[i], y = y_[i], z = z_[i], radius = radius_[i];
    for (std::uint32_t j = begin; j < end; ++j) {
        const float dx = x_[j] - x, dy = y_[j] - y, dz = z_[j] - z, reach = radius_[j] + radius;
        if (dx * dx + dy * dy + dz * dz < reach * reach && !(kinds_[i] & kinds_[j] & kIsFixed) && !((kinds_[i] | kinds_[j]) & kIsFast))
            pairs_.push_back({i, j});
    }
}

void PairSearch::pair_level(int level) {
    const int side = cells_a_side(level), padded = padded_side(level), slab = padded * padded;
    const std::uint32_t* start = &start_[first_start(level)];
    for (int z = 1; z <= side; ++z)
        for (int y = 1; y <= side; ++y)
            for (int x = 1; x <= side; ++x) {
                const std::uint32_t* at = start + z * slab + y * padded + x;
                for (std::uint32_t i = at[0]; i < at[1]; ++i) {
                    test(i, i + 1, at[2]);
                    test(i, at[padded - 1], at[padded + 2]);
                    test(i, at[slab - padded - 1], at[slab - padded + 2]);
                    test(i, at[slab - 1], at[slab + 2]);
                    test(i, at[slab + padded - 1], at[slab + padded + 2]);
                }
            }
}

void PairSearch::pair_with_coarser(int level, int coarser, double coarse_cells_per_m) {
    const int side = cells_a_side(level), padded = padded_side(level), coarse_side = cells_a_side(coarser),
              coarse_padded = padded_side(coarser);
    const std::uint32_t* start = &start_[first_start(level)];
    const std::uint32_t* coarse_start = &start_[first_start(coarser)];
    const auto coarse = [&](float position) {
        return std::clamp(static_cast<int>(static_cast<double>(position) * coarse_cells_per_m), 0, coarse_side - 1) + 1;
    };
    for (int z = 1; z <= side; ++z)
        for (int y = 1; y <= side; ++y) {
            const std::uint32_t* row = start + (z * padded + y) * padded;
            for (std::uint32_t i = row[1]; i < row[side + 1]; ++i) {
                const int cx = coarse(x_[i]), cy = coarse(y_[i]), cz = coarse(z_[i]);
                for (int dz = -1; dz <= 1; ++dz)
                    for (int dy = -1; dy <= 1; ++dy) {
                        const std::uint32_t* at = coarse_start + ((cz + dz) * coarse_padded + cy + dy) * coarse_padded + cx;
                        test(i, at[-1], at[2]);
                    }
            }
        }
}

}  // namespace meld::physics
