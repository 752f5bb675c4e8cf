#include "runtime/sim/core/setup/expected_share.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <unordered_set>
#include <utility>
#include <vector>

#include "runtime/engine/tuple/program_actions.h"
#include "runtime/sim/core/setup/setup.h"
#include "runtime/world/description/measure.h"
#include "runtime/world/description/populate.h"
#include "runtime/world/ensemble/brick_table.h"
#include "runtime/world/ensemble/ensemble.h"
#include "runtime/world/partition/partition.h"

namespace meld::sim {

namespace {

using Bricks = std::vector<std::unordered_set<std::uint64_t>>;  // By process.

// The cells of a brick near each of the 27 around it.
using NearCells = std::array<std::bitset<kBrickCells>, kBrickNeighbours>;

std::size_t number_of(const partition::Halo::Side& side) {
    return static_cast<std::size_t>(side.dx + 1 + 3 * (side.dy + 1) + 9 * (side.dz + 1));
}

NearCells near_cells(const partition::Halo& halo) {
    NearCells near;
    for (u32 n = 0; n < kBrickNeighbours; ++n) {
        const world::Cell step = world::Lattice::brick_offset(n);
        const partition::Halo::Side side{static_cast<std::int8_t>(step.x), static_cast<std::int8_t>(step.y),
                                         static_cast<std::int8_t>(step.z), 0};
        for (std::uint32_t cell = 0; cell < kBrickCells; ++cell) near[number_of(side)][cell] = halo.near(side, cell);
    }
    return near;
}

// The catoms of a brick that other processes see are ghosts there: as many as the cells near them, if the brick is full.
void add_ghosts(const partition::Halo& halo, const NearCells& near, const world::Cell brick, std::uint32_t catoms, int owner,
                std::vector<ExpectedShare>& shares, bool around, Bricks& bricks) {
    const std::vector<partition::Halo::Side> sides = halo.sides(brick);
    std::vector<int> others;
    for (const auto& side : sides)
        if (side.process != owner && std::ranges::find(others, side.process) == others.end()) others.push_back(side.process);
    for (const int other : others) {
        std::bitset<kBrickCells> seen;
        for (const auto& side : sides)
            if (side.process == other) seen |= near[number_of(side)];
        const auto p = static_cast<std::size_t>(other);
        shares[p].ghosts += catoms * static_cast<double>(seen.count()) / kBrickCells;
        if (around)
            bricks[p].insert(world::packed(brick));
        else
            ++shares[p].bricks;
    }
}

std::vector<ExpectedShare> count_cells(const world::World& world, const world::Lattice& lattice, const ModuleInfo& module, int processes,
                                       const BrickCounts& counts) {
    const partition::Partition partition(counts, processes);
    const world::Ensemble none(lattice, std::function<bool(world::Cell)>());
    const partition::Halo halo(none, partition, 0, Setup::reach(world, tuple::ProgramActions(module)));
    const bool around = Setup::looks_around(world);
    std::vector<ExpectedShare> shares(static_cast<std::size_t>(processes));
    Bricks bricks(shares.size());
    for (const auto& [key, catoms] : counts) {
        const int owner = partition.owner(key);
        const auto p = static_cast<std::size_t>(owner);
        shares[p].catoms += catoms;
        ++shares[p].with_catoms;
        ++shares[p].bricks;
        if (!around) continue;
        const world::Cell brick = lattice.brick_at(key);
        bricks[p].insert(world::packed(brick));
        for (u32 n = 0; n < kBrickNeighbours; ++n)
            if (const world::Cell there = brick + world::Lattice::brick_offset(n); lattice.brick_in_range(there))
                bricks[p].insert(world::packed(there));
    }
    const NearCells near = processes > 1 ? near_cells(halo) : NearCells();
    partition::each_border_brick(partition, lattice, counts, {}, [&](std::size_t i) {
        const auto& [key, catoms] = counts[i];
        add_ghosts(halo, near, lattice.brick_at(key), catoms, partition.owner(key), shares, around, bricks);
    });
    for (std::size_t p = 0; around && p < shares.size(); ++p) shares[p].bricks = static_cast<double>(bricks[p].size());
    return shares;
}

}  // namespace

ExpectedShares expected_shares(const world::World& world, const ModuleInfo& module, int processes,
                               const std::optional<BrickCounts>& counts) {
    if (!counts) {
        const double all = world::measure(world).map([](const world::WorldSize& size) { return size.cells_estimate; }).value_or(0);
        const double catoms = all / processes;
        return {all, {.catoms = catoms, .bricks = catoms / kBrickCells, .with_catoms = catoms / kBrickCells, .exact = false}};
    }
    ExpectedShares expected{.catoms = static_cast<double>(world.placed.size())};
    for (const auto& [key, catoms] : *counts) expected.catoms += catoms;
    std::vector<ExpectedShare> shares = count_cells(world, world::Lattice(world.lattice), module, processes, *counts);
    // Listed bodies begin on process 0.
    shares[0].catoms += static_cast<double>(world.placed.size());
    expected.largest = *std::ranges::max_element(shares, {}, [](const ExpectedShare& s) { return s.catoms + s.ghosts; });
    return expected;
}

}  // namespace meld::sim
