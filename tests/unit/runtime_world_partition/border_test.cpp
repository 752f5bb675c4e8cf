#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "runtime/world/partition/partition.h"

namespace meld::partition {
namespace {

using world::Lattice;
using world::LatticeKind;
using Bricks = std::vector<std::pair<BrickKey, std::uint32_t>>;

// A thick shell of bricks, so that there are empty ones around and inside; at the limit of the world if that is its centre.
Bricks shell(const Lattice& lattice, Cell centre) {
    std::map<BrickKey, std::uint32_t> bricks;
    const int reach_z = lattice.flat() ? 0 : 9;
    for (int x = -9; x <= 9; ++x)
        for (int y = -9; y <= 9; ++y)
            for (int z = -reach_z; z <= reach_z; ++z) {
                const int distance = x * x + y * y + z * z;
                const Cell brick = centre + Cell{x, y, z};
                if (distance < 12 || distance > 80 || !lattice.brick_in_range(brick)) continue;
                bricks[lattice.brick_key(brick)] = static_cast<std::uint32_t>(1 + (x + 9) * 20);
            }
    return {bricks.begin(), bricks.end()};
}

TEST(Border, HasTheBricksThatALookAroundEachFinds) {
    for (const LatticeKind kind : {LatticeKind::Square, LatticeKind::Cubic}) {
        const Lattice lattice(kind);
        const std::int32_t limit = world::kCellLimit >> lattice.brick_bits()[0];
        for (const Cell centre : {Cell{}, Cell{37, -21, 0}, Cell{limit - 4, 5, 0}, Cell{-limit, 0, 0}}) {
            const Bricks bricks = shell(lattice, centre);
            for (const int processes : {1, 2, 3, 8, 100}) {
                const Partition partition(bricks, processes);
                const world::Ensemble none(lattice, std::function<bool(Cell)>());
                const Halo halo(none, partition, 0, 1);
                for (const std::optional<int> of : {std::optional<int>(), std::optional(0), std::optional(processes - 1)}) {
                    std::vector<std::size_t> expected, found;
                    for (std::size_t i = 0; i < bricks.size(); ++i) {
                        const auto sides = halo.sides(lattice.brick_at(bricks[i].first));
                        const int owner = partition.owner(bricks[i].first);
                        const bool mixed = std::ranges::any_of(sides, [&](const auto& side) { return side.process != owner; });
                        if (mixed && (!of || std::ranges::any_of(sides, [&](const auto& side) { return side.process == *of; })))
                            expected.push_back(i);
                    }
                    each_border_brick(partition, lattice, bricks, of, [&](std::size_t i) { found.push_back(i); });
                    EXPECT_EQ(found, expected) << processes << " processes, of " << of.value_or(-1);
                }
            }
        }
    }
}

TEST(Border, IsFoundFromTheBricksThatAreThere) {
    const Lattice lattice(LatticeKind::Cubic);
    const Bricks bricks = shell(lattice, {3, 4, 5});
    const Partition partition(bricks, 3);
    world::Ensemble ensemble(lattice, std::function<bool(Cell)>());
    for (const auto& [key, catoms] : bricks) ensemble.slot(lattice.brick_at(key));
    Halo halo(ensemble, partition, 1, 1);
    halo.prepare();
    for (world::Slot slot = 1; slot <= ensemble.brick_count(); ++slot) {
        const auto sides = halo.sides(ensemble.brick(slot));
        EXPECT_EQ(halo.inside(slot), std::ranges::all_of(sides, [](const auto& side) { return side.process == 1; }));
    }
}

}  // namespace
}  // namespace meld::partition
