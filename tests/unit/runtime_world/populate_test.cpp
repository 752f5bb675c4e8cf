#include "runtime/world/description/populate.h"
#include "runtime/world/description/measure.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "runtime/world/ensemble/fit.h"
#include "runtime/world/ensemble/target.h"

namespace meld::world {
namespace {

World world_on(const std::string& text, LatticeKind kind, std::vector<Cell> cells = {}) {
    World world;
    world.lattice = kind;
    if (!text.empty()) world.body = *Shape::parse(text);
    world.cells = std::move(cells);
    sort_cells(world.cells, Lattice(kind));
    return world;
}

// Asks each cell of a box that holds the whole body.
std::map<BrickKey, std::set<std::uint32_t>> brute_force(const World& world, const Lattice& lattice) {
    std::map<BrickKey, std::set<std::uint32_t>> bricks;
    const std::set<Cell> listed(world.cells.begin(), world.cells.end());
    const int reach = lattice.flat() ? 80 : 45, reach_z = lattice.flat() ? 0 : reach;
    for (int x = -reach; x <= reach; ++x) {
        for (int y = -reach; y <= reach; ++y) {
            for (int z = -reach_z; z <= reach_z; ++z) {
                const Cell cell = {x, y, z};
                if (!listed.contains(cell) && !world.body.contains(lattice.position(cell))) continue;
                bricks[lattice.brick_key(lattice.brick_of(cell))].insert(lattice.number_in_brick(cell));
            }
        }
    }
    return bricks;
}

TEST(Populate, AgreesWithAskingEachCellForAnyNumberOfShares) {
    const std::vector<Cell> scattered = {{0, 0, 0}, {30, -20, 0}, {31, -20, 0}, {-40, 40, 0}, {5, 0, 0}};
    const std::vector<std::pair<std::string, std::vector<Cell>>> bodies = {
        {"box(20, 31, 17)", {}}, {"sphere(19)", scattered},  {"minus(box(30,30,30), cylinder(8, 50))", {}},
        {"", scattered},         {"trumpet(40)", scattered}, {"torus(15, 3)", {}}};
    for (const LatticeKind kind : {LatticeKind::Square, LatticeKind::Hex, LatticeKind::Cubic, LatticeKind::Fcc}) {
        const Lattice lattice(kind);
        for (const auto& [text, cells] : bodies) {
            const World world = world_on(text, kind, cells);
            const auto expected = brute_force(world, lattice);
            Workers workers(3);
            EXPECT_EQ(count_bricks(world, lattice, 1, 2, &workers), count_bricks(world, lattice, 1, 2)) << text;
            for (const int shares : {1, 2, 3, 7, 64}) {
                std::map<BrickKey, std::uint32_t> counted;
                for (int share = 0; share < shares; ++share) {
                    BrickKey before = 0;
                    for (const auto& [brick, count] : count_bricks(world, lattice, share, shares)) {
                        EXPECT_TRUE(counted.emplace(brick, count).second) << text;
                        EXPECT_TRUE(before == 0 || before < brick);
                        before = brick;
                    }
                }
                ASSERT_EQ(counted.size(), expected.size()) << text << " on " << lattice.name();
                for (const auto& [brick, numbers] : expected) EXPECT_EQ(counted[brick], numbers.size());
            }
            std::vector<std::uint32_t> numbers = {1, 2, 3};
            for (const auto& [brick, cells_there] : expected) {
                cells_of_brick(world, lattice, brick, numbers);
                EXPECT_EQ(numbers, std::vector<std::uint32_t>(cells_there.begin(), cells_there.end()));
            }
        }
    }
}

TEST(Measure, IsExactForABoxAndNeverTooLow) {
    for (const LatticeKind kind : {LatticeKind::Square, LatticeKind::Hex, LatticeKind::Cubic, LatticeKind::Fcc}) {
        const Lattice lattice(kind);
        for (const std::string text : {"box(20, 31, 17)", "move(box(10, 10, 10), 2, 3, -4)", "sphere(19)", "trumpet(40)", "torus(15, 3)"}) {
            const World world = world_on(text, kind);
            const Result<WorldSize> size = measure(world);
            ASSERT_TRUE(size);
            const auto catoms = static_cast<double>(count_catoms(world, lattice));
            EXPECT_GE(size->cells_upper_bound, catoms) << text;
            if (text.find("box") != std::string::npos) {
                EXPECT_EQ(size->cells_upper_bound, catoms) << text << lattice.name();
            }
            EXPECT_NEAR(size->cells_estimate, catoms, 0.05 * catoms) << text << lattice.name();
            EXPECT_LT(size->cells_upper_bound, 3 * catoms + 100) << text << lattice.name();
        }
    }
}

TEST(Measure, EstimatesALargeThinShell) {
    const World world = world_on("trumpet(900)", LatticeKind::Cubic);
    const auto catoms = static_cast<double>(count_catoms(world, Lattice(world.lattice)));
    EXPECT_NEAR(measure(world)->cells_estimate, catoms, 0.05 * catoms);
}

TEST(Measure, AnswersForAbsurdSizes) {
    const Result<WorldSize> huge = measure(world_on("box(1e6, 1e6, 1e6)", LatticeKind::Cubic));
    ASSERT_TRUE(huge);
    EXPECT_EQ(huge->cells_upper_bound, 1e18);
    EXPECT_GE(measure(world_on("sphere(5e5)", LatticeKind::Cubic))->cells_upper_bound, 5.2e17);
    const Result<WorldSize> absurd = measure(world_on("box(1e9, 1e9, 1e9)", LatticeKind::Cubic));
    ASSERT_FALSE(absurd);
    EXPECT_EQ(absurd.error().problem,
              "the body has up to 1e+27 cells and reaches 5e+08 catom diameters from the origin, but cells lie within 1048576");
    EXPECT_FALSE(measure(World{}));
}

// The cells that a target has in the bricks of a shape that holds it; `fill` and `contains` must agree on them.
std::set<Cell> cells_of(const Target& target, const Shape& around, const Lattice& lattice) {
    std::set<Cell> chosen;
    for_each_brick(around, lattice, [&](Cell brick) {
        std::array<std::uint64_t, 8> bits{};
        target.fill(brick, bits);
        for (std::uint32_t number = 0; number < kBrickCells; ++number) {
            const Cell cell = lattice.cell_in_brick(brick, number);
            const bool set = bits[number / 64] >> number % 64 & 1;
            EXPECT_EQ(set, target.contains(cell));
            if (set) chosen.insert(cell);
        }
        return true;
    });
    return chosen;
}

bool connected(std::set<Cell> cells, const Lattice& lattice) {
    std::vector<Cell> reached = {*cells.begin()};
    cells.erase(reached[0]);
    while (!reached.empty()) {
        const Cell cell = reached.back();
        reached.pop_back();
        for (int port = 0; port < lattice.ports(); ++port) {
            if (cells.erase(lattice.neighbour(cell, port)) > 0) reached.push_back(lattice.neighbour(cell, port));
        }
    }
    return cells.empty();
}

TEST(Target, KeepsExactlyAsManyConnectedCellsAsThereIsMass) {
    for (const LatticeKind kind : {LatticeKind::Cubic, LatticeKind::Fcc, LatticeKind::Square}) {
        const Lattice lattice(kind);
        World world = world_on("box(10, 10, 10)", kind);
        world.target = *Shape::parse("trumpet(90)");
        world.target_is_mass = true;
        world.held = 1;
        const Result<Target> target = Target::make(world, lattice);
        ASSERT_TRUE(target) << target.error().message();
        const std::uint64_t mass = 2 * count_catoms(world, lattice);
        EXPECT_EQ(target->cells(), mass);
        const std::set<Cell> chosen = cells_of(*target, *world.target, lattice);
        EXPECT_EQ(chosen.size(), mass);
        for (const Cell cell : chosen) EXPECT_TRUE(world.target->contains(lattice.position(cell)));
        EXPECT_TRUE(connected(chosen, lattice));
    }
}

TEST(Target, FitsAShapeToTheMass) {
    for (const LatticeKind kind : {LatticeKind::Cubic, LatticeKind::Fcc, LatticeKind::Square, LatticeKind::Hex}) {
        const Lattice lattice(kind);
        // A plane cuts a horn into two walls, which are not connected.
        const char* horn = lattice.flat() ? "ellipsoid(8, 2, 1)" : "move(trumpet(80, 40, 9), -30, 0, 0)";
        for (const char* shape : {"sphere(30)", "box(3, 4, 50)", horn, "torus(12, 3)", "sphere(0.1)"}) {
            SCOPED_TRACE(shape);
            World world = world_on("box(25, 23, 11)", kind);
            world.target = *Shape::parse(shape);
            world.target_fits_mass = true;
            const Result<Target> target = Target::make(world, lattice);
            ASSERT_TRUE(target) << target.error().message();
            const std::uint64_t mass = count_catoms(world, lattice);
            EXPECT_EQ(target->cells(), mass);
            const Box box = Shape::parse(target->text())->bounds();
            double reach = 0;
            for (std::size_t i = 0; i < 3; ++i) reach = std::max({reach, std::abs(box.low[i]), std::abs(box.high[i])});
            const Shape around = *Shape::parse(fmt::format("box({0}, {0}, {0})", 2 * reach + 4));
            const std::set<Cell> chosen = cells_of(*target, around, lattice);
            EXPECT_EQ(chosen.size(), mass);
            EXPECT_TRUE(connected(chosen, lattice));
        }
    }
}

TEST(Fit, LeavesOutCellsOfTheRimAlone) {
    const Lattice lattice(LatticeKind::Cubic);
    const Shape sphere = *Shape::parse("sphere(1)");
    const Result<FittedShape> fitted = fit_shape(sphere, lattice, 1000);
    ASSERT_TRUE(fitted);
    // A ball has 1,021 cells from this radius on, of which 72 lie on its surface.
    EXPECT_NEAR(fitted->scale, std::sqrt(38), 1e-9);
    EXPECT_EQ(fitted->surplus.size(), 21u);
    for (const CellKey key : fitted->surplus) {
        const Vec3 at = lattice.position(lattice.cell_at(key));
        EXPECT_NEAR(at[0] * at[0] + at[1] * at[1] + at[2] * at[2], 38, 1e-9);
    }
}

TEST(Fit, KeepsAShapeThatFitsAndNamesOneThatCannot) {
    const Lattice cubic(LatticeKind::Cubic), square(LatticeKind::Square);
    EXPECT_EQ(fit_shape(*Shape::parse("box(4, 5, 6)"), cubic, 120)->scale, 1);
    EXPECT_EQ(fit_shape(*Shape::parse("move(box(4, 5, 6), 0, 0, 9)"), square, 120).error().problem,
              "the target move(box(4, 5, 6), 0, 0, 9) cannot be scaled to hold 120 cells");
}

TEST(Target, SaysWhenTheShapeIsTooSmallOrOutOfReach) {
    const Lattice lattice(LatticeKind::Cubic);
    World world = world_on("box(10, 10, 10)", LatticeKind::Cubic);
    world.target = *Shape::parse("box(9, 9, 9)");
    world.target_is_mass = true;
    EXPECT_EQ(Target::make(world, lattice).error().problem,
              "the target box(9, 9, 9) has 729 cells but the catoms and what they hold would fill 1000");
    world.target = *Shape::parse("move(box(20, 20, 20), 40, 0, 0)");
    EXPECT_EQ(Target::make(world, lattice).error().suggestion, "move the target or the body so that they overlap");
    world.target = *Shape::parse("union(box(9, 9, 9), move(box(20, 20, 20), 40, 0, 0))");
    world.target_is_mass = false;
    world.target_cells = 800;
    EXPECT_EQ(
        Target::make(world, lattice).error().problem,
        "the target union(box(9, 9, 9), move(box(20, 20, 20), 40, 0, 0)) has 8729 cells, 729 of them connected to the body, but [target] "
        "cells asks for 800");
}

TEST(Target, IsTheWholeShapeUnlessItsCellsAreCounted) {
    World world = world_on("box(4, 4, 4)", LatticeKind::Cubic);
    const Lattice lattice(LatticeKind::Cubic);
    EXPECT_FALSE(Target::make(world, lattice)->contains({0, 0, 0}));
    world.target = *Shape::parse("sphere(3)");
    EXPECT_TRUE(Target::make(world, lattice)->contains({3, 0, 0}));
    EXPECT_FALSE(Target::make(world, lattice)->contains({3, 1, 0}));
    EXPECT_EQ(Target::make(world, lattice)->cells(), std::nullopt);
}

}  // namespace
}  // namespace meld::world
