#include "runtime/world/ensemble/ensemble.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "runtime/world/ensemble/target.h"

namespace meld::world {
namespace {

TEST(Ensemble, StartsWithAnEmptyBrickThatIsItsOwnNeighbour) {
    const Ensemble ensemble(Lattice(LatticeKind::Cubic), {});
    const Geometry g = ensemble.geometry();
    EXPECT_EQ(ensemble.brick_count(), 0u);
    for (u32 n = 0; n < kBrickNeighbours; ++n) EXPECT_EQ(g.brick_neighbours[n], 0u);
    for (u32 cell = 0; cell < kBrickCells; ++cell) {
        EXPECT_EQ(g.cell_catom[cell], -1);
        EXPECT_FALSE(in_target(g, cell));
        for (int port = 0; port < g.ports; ++port) EXPECT_EQ(catom_towards(g, cell, port), -1);
    }
}

TEST(Ensemble, AddsRunsOfCatomsAsIfOneByOne) {
    const Lattice lattice(LatticeKind::Cubic);
    Ensemble one_by_one(lattice, {}), runs(lattice, {});
    const Cell brick = {1, -2, 3};
    std::uint64_t id = 7;
    for (const auto& [number, count] : {std::pair(3u, 5u), {100u, 1u}, {500u, 12u}}) {
        for (u32 i = 0; i < count; ++i) one_by_one.add(id + i, lattice.cell_in_brick(brick, number + i), kCatomOwned);
        const Slot slot = runs.slot(brick);
        EXPECT_TRUE(runs.empty(slot, number, count));
        const Catom next = static_cast<Catom>(runs.index_count());
        EXPECT_EQ(runs.add_run(id, slot, number, count, kCatomOwned), next);
        EXPECT_EQ(runs.index_count(), next + count);
        EXPECT_FALSE(runs.empty(slot, number + count - 1, 1));
        // The next run has other numbers, and is found too.
        EXPECT_EQ(runs.find(id + count - 1), runs.index_count() - 1);
        id += 2 * count;
    }
    ASSERT_EQ(runs.index_count(), one_by_one.index_count());
    EXPECT_EQ(runs.owned_count(), 18u);
    for (Catom catom = 0; catom < runs.index_count(); ++catom) {
        EXPECT_EQ(runs.id(catom), one_by_one.id(catom));
        EXPECT_EQ(runs.cell(catom), one_by_one.cell(catom));
        EXPECT_EQ(runs.state(catom), kCatomOwned);
        EXPECT_EQ(runs.at(runs.cell(catom)), catom);
        EXPECT_EQ(runs.key_of(catom), lattice.key(runs.cell(catom)));
    }
    EXPECT_EQ(runs.find(7 + 5), std::nullopt);
}

// Some bricks of a body with a hole, and parts of bricks at its surface.
bool in_body(Cell cell) { return cell.x % 11 != 3 && cell.x * cell.x + cell.y * cell.y + 4 * cell.z * cell.z < 700; }

TEST(Ensemble, AddsBricksOnAnyNumberOfWorkersAsIfOneByOne) {
    for (const LatticeKind kind : {LatticeKind::Square, LatticeKind::Fcc}) {
        const Lattice lattice(kind);
        const auto in_target = [](Cell cell) { return cell.x > cell.y; };
        const auto fill = [&](Cell brick, std::span<std::uint64_t, 8> bits) {
            for (std::uint32_t number = 0; number < kBrickCells; ++number)
                if (in_body(lattice.cell_in_brick(brick, number))) bits[number / 64] |= std::uint64_t{1} << number % 64;
        };
        std::map<BrickKey, std::uint32_t> counts;
        for (int x = -30; x <= 30; ++x)
            for (int y = -30; y <= 30; ++y)
                for (int z = lattice.flat() ? 0 : -15; z <= (lattice.flat() ? 0 : 15); ++z)
                    if (in_body({x, y, z})) ++counts[lattice.brick_key(lattice.brick_of({x, y, z}))];
        const std::vector<std::pair<BrickKey, std::uint32_t>> bricks(counts.begin(), counts.end());
        Ensemble one_by_one(lattice, in_target);
        std::uint64_t id = 5;
        for (const auto& [key, count] : bricks)
            for (std::uint32_t number = 0; number < kBrickCells; ++number)
                if (const Cell cell = lattice.cell_in_brick(lattice.brick_at(key), number); in_body(cell))
                    one_by_one.add(id++, cell, kCatomOwned);
        for (const int threads : {1, 2, 3}) {
            Workers workers(threads);
            Ensemble at_once(lattice, in_target);
            at_once.add_bricks(bricks, 5, fill, kCatomOwned, workers);
            ASSERT_EQ(at_once.index_count(), one_by_one.index_count());
            ASSERT_EQ(at_once.brick_count(), one_by_one.brick_count());
            EXPECT_EQ(at_once.owned_count(), one_by_one.owned_count());
            for (Catom catom = 0; catom < at_once.index_count(); ++catom) {
                ASSERT_EQ(at_once.id(catom), one_by_one.id(catom));
                ASSERT_EQ(at_once.key_of(catom), one_by_one.key_of(catom));
                ASSERT_EQ(at_once.at(at_once.cell(catom)), catom);
                ASSERT_EQ(at_once.state(catom), kCatomOwned);
            }
            const Geometry ours = at_once.geometry(), theirs = one_by_one.geometry();
            const std::size_t slots = at_once.brick_count() + 1;
            EXPECT_TRUE(std::equal(ours.cell_catom, ours.cell_catom + slots * kBrickCells, theirs.cell_catom));
            EXPECT_TRUE(std::equal(ours.brick_neighbours, ours.brick_neighbours + slots * kBrickNeighbours, theirs.brick_neighbours));
            EXPECT_TRUE(std::equal(ours.brick_target, ours.brick_target + slots * kBrickCells / 64, theirs.brick_target));
            EXPECT_TRUE(std::equal(ours.brick_origin, ours.brick_origin + slots * 3, theirs.brick_origin));
        }
    }
}

TEST(Ensemble, FindsNeighboursAcrossBricksOnEachLattice) {
    for (const LatticeKind kind : {LatticeKind::Square, LatticeKind::Hex, LatticeKind::Cubic, LatticeKind::Fcc}) {
        const Lattice lattice(kind);
        Ensemble ensemble(lattice, {});
        std::mt19937 random(7);
        std::uniform_int_distribution<int> coordinate(-20, 20);
        std::map<Cell, Catom> stands;
        for (std::uint64_t id = 0; id < 3'000; ++id) {
            const Cell cell = {coordinate(random), coordinate(random), lattice.flat() ? 0 : coordinate(random) / 3};
            if (!stands.contains(cell)) stands[cell] = ensemble.add(id, cell, kCatomOwned);
        }
        const Geometry g = ensemble.geometry();
        for (const auto& [cell, catom] : stands) {
            EXPECT_EQ(ensemble.cell(catom), cell);
            EXPECT_EQ(ensemble.at(cell), catom);
            const i32 origin[3] = {cell.x, cell.y, cell.z};
            for (i32 axis = 0; axis < 3; ++axis) EXPECT_EQ(cell_coordinate(g, g.catom_site[catom], axis), origin[axis]);
            for (int port = 0; port < lattice.ports(); ++port) {
                const auto there = stands.find(lattice.neighbour(cell, port));
                EXPECT_EQ(catom_towards(g, g.catom_site[catom], port), there == stands.end() ? -1 : static_cast<i32>(there->second));
            }
        }
    }
}

TEST(Ensemble, GivesTheLowestFreeIndexAgain) {
    Ensemble ensemble(Lattice(LatticeKind::Cubic), {});
    for (int i = 0; i < 10; ++i) EXPECT_EQ(ensemble.add(static_cast<std::uint64_t>(i), {i, 0, 0}, kCatomOwned), static_cast<Catom>(i));
    ensemble.remove(7);
    ensemble.remove(2);
    ensemble.remove(5);
    EXPECT_EQ(ensemble.owned_count(), 7u);
    EXPECT_EQ(ensemble.index_count(), 10u);
    EXPECT_EQ(ensemble.at({2, 0, 0}), std::nullopt);
    EXPECT_EQ(ensemble.add(20, {0, 1, 0}, kCatomGhost), 2u);
    EXPECT_EQ(ensemble.add(21, {1, 1, 0}, kCatomGhost), 5u);
    EXPECT_EQ(ensemble.add(22, {2, 1, 0}, kCatomGhost), 7u);
    EXPECT_EQ(ensemble.add(23, {3, 1, 0}, kCatomGhost), 10u);
    EXPECT_EQ(ensemble.ghost_count(), 4u);
    ensemble.set_state(2, kCatomOwned);
    EXPECT_EQ(ensemble.ghost_count(), 3u);
    EXPECT_EQ(ensemble.owned_count(), 8u);
}

TEST(Ensemble, MovesACatomFromCellToCell) {
    Ensemble ensemble(Lattice(LatticeKind::Fcc), {});
    const Catom catom = ensemble.add(1, {0, 0, 0}, kCatomOwned);
    ensemble.move(catom, {-9, 30, 4});
    EXPECT_EQ(ensemble.at({0, 0, 0}), std::nullopt);
    EXPECT_EQ(ensemble.at({-9, 30, 4}), catom);
    EXPECT_EQ(ensemble.cell(catom), (Cell{-9, 30, 4}));
}

TEST(Ensemble, FindsCatomsByIdWhileTheyComeAndGo) {
    Ensemble ensemble(Lattice(LatticeKind::Square), {});
    std::map<std::uint64_t, Catom> known;
    std::mt19937_64 random(11);
    int x = 0;
    EXPECT_EQ(ensemble.find(3), std::nullopt);
    for (int step = 0; step < 20'000; ++step) {
        const std::uint64_t id = random() % 500;
        EXPECT_EQ(ensemble.find(id).has_value(), known.contains(id));
        if (const auto there = known.find(id); there != known.end()) {
            EXPECT_EQ(ensemble.find(id), there->second);
            ensemble.remove(there->second);
            known.erase(there);
        } else {
            known[id] = ensemble.add(id, {x++, 0, 0}, kCatomOwned);
        }
    }
}

TEST(Ensemble, SurroundsABrickWithAllItsNeighbours) {
    Ensemble ensemble(Lattice(LatticeKind::Cubic), {});
    const Slot slot = ensemble.slot({-1, 2, 3});
    ensemble.surround(slot);
    EXPECT_EQ(ensemble.brick_count(), 27u);
    const Geometry g = ensemble.geometry();
    for (u32 n = 0; n < kBrickNeighbours; ++n) {
        EXPECT_EQ(ensemble.brick(g.brick_neighbours[slot * kBrickNeighbours + n]), (Cell{-1, 2, 3}) + Lattice::brick_offset(n));
    }
    Ensemble flat(Lattice(LatticeKind::Hex), {});
    flat.surround(flat.slot({0, 0, 0}));
    EXPECT_EQ(flat.brick_count(), 9u);
    Ensemble edge(Lattice(LatticeKind::Cubic), {});
    edge.surround(edge.slot({(kCellLimit >> 3) - 1, 0, 0}));
    EXPECT_EQ(edge.brick_count(), 18u);
}

TEST(Ensemble, KnowsTheTargetOfEachBrickItMakes) {
    const Lattice lattice(LatticeKind::Cubic);
    const auto in_ball = [](Cell c) { return c.x * c.x + c.y * c.y + c.z * c.z <= 36; };
    World world;
    world.target = *Shape::parse("sphere(6)");
    const Target target = *Target::make(world, lattice);
    Ensemble by_function(lattice, in_ball), by_target(lattice, target);
    for (Ensemble* ensemble : {&by_function, &by_target}) {
        for (int x = -9; x < 9; ++x) {
            for (int y = -9; y < 9; ++y) {
                const Cell cell = {x, y, 3};
                const Slot slot = ensemble->slot(lattice.brick_of(cell));
                EXPECT_EQ(ensemble->target(cell), in_ball(cell));
                EXPECT_EQ(in_target(ensemble->geometry(), slot << kBrickCellBits | lattice.number_in_brick(cell)), in_ball(cell));
            }
        }
    }
}

}  // namespace
}  // namespace meld::world
