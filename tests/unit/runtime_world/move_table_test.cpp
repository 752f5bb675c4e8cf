#include "runtime/world/lattice/move_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace meld::world {
namespace {

MoveTable named(std::string_view name, LatticeKind lattice) {
    return MoveTable(lattice, std::string(name), MoveTable::named(name, lattice));
}

std::vector<Cell> possible(const MoveTable& table, Cell from, const std::set<Cell>& full) {
    std::vector<Cell> found;
    std::vector<std::uint8_t> known;
    table.possible(from, [&](Cell c) { return full.contains(from + c); }, known, found);
    return found;
}

TEST(MoveTable, NamesTheTablesOfEachLattice) {
    using Names = std::vector<std::string_view>;
    EXPECT_EQ(MoveTable::names(LatticeKind::Square), (Names{"sliding", "pivoting", "leapfrog", "monkey"}));
    EXPECT_EQ(MoveTable::names(LatticeKind::Cubic), (Names{"sliding", "pivoting", "leapfrog", "monkey"}));
    EXPECT_EQ(MoveTable::names(LatticeKind::Hex), (Names{"rolling", "pivoting", "monkey"}));
    EXPECT_EQ(MoveTable::names(LatticeKind::Fcc), (Names{"rolling"}));
    EXPECT_EQ(MoveTable::lattices("pivoting"), (Names{"square", "cubic", "hex"}));
    EXPECT_TRUE(MoveTable::lattices("flying").empty());
    EXPECT_TRUE(MoveTable::named("sliding", LatticeKind::Fcc).empty());
}

// Eight directions of a slide and eight of a turn, on each side of a pivot; 24 of each in space.
TEST(MoveTable, GeneratesEachMoveOnce) {
    EXPECT_EQ(named("sliding", LatticeKind::Square).from({}).size(), 16u);
    EXPECT_EQ(named("sliding", LatticeKind::Cubic).from({}).size(), 48u);
    EXPECT_EQ(named("rolling", LatticeKind::Hex).from({}).size(), 12u);
}

TEST(MoveTable, StaysWithinWhatProcessesKnow) {
    for (const LatticeKind lattice : {LatticeKind::Square, LatticeKind::Hex, LatticeKind::Cubic, LatticeKind::Fcc})
        for (const std::string_view name : MoveTable::names(lattice)) {
            const MoveTable table = named(name, lattice);
            EXPECT_LE(table.longest(), MoveTable::kMaxBy) << name;
            EXPECT_LE(table.reach(), MoveTable::kMaxAway) << name;
            EXPECT_GE(table.reach(), table.longest());
        }
}

// A turned move leads as far as the one that is listed, and its cells are as far away, whatever the layer.
TEST(MoveTable, TurnsMovesWithoutDeformingThem) {
    for (const LatticeKind kind : {LatticeKind::Square, LatticeKind::Hex, LatticeKind::Cubic, LatticeKind::Fcc})
        for (const std::string_view name : MoveTable::names(kind)) {
            const Lattice lattice(kind);
            const auto away = [&](Cell from, Cell by) {
                const Vec3 a = lattice.position(from), b = lattice.position(from + by);
                return std::lround(1e6 * std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
            };
            std::set<std::vector<long>> listed, turned;
            const auto shape_of = [&](Cell from, const Move& move) {
                std::vector<long> shape = {away(from, move.by)};
                std::vector<long> rest;
                for (const Cell c : move.full) rest.push_back(away(from, c));
                for (const Cell c : move.empty)
                    if (c != move.by) rest.push_back(-away(from, c));
                std::ranges::sort(rest);
                shape.insert(shape.end(), rest.begin(), rest.end());
                return shape;
            };
            for (const ListedMove& one : MoveTable::named(name, kind)) listed.insert(shape_of({}, one.move));
            const MoveTable table = named(name, kind);
            for (const Cell from : {Cell{}, Cell{3, -2, lattice.flat() ? 0 : 1}})
                for (const Move& move : table.from(from)) turned.insert(shape_of(from, move));
            EXPECT_EQ(listed, turned) << name;
        }
}

TEST(MoveTable, FindsWhatASquareOnARowCanDo) {
    const std::set<Cell> row = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
    EXPECT_EQ(possible(named("sliding", LatticeKind::Square), {1, 1, 0}, row), (std::vector<Cell>{{-1, 0, 0}, {1, -1, 0}}));
    EXPECT_EQ(possible(named("pivoting", LatticeKind::Square), {1, 1, 0}, row), (std::vector<Cell>{{-1, 0, 0}, {1, -1, 0}}));
    // A ceiling is no hindrance to a slide.
    std::set<Cell> below = row;
    below.insert({0, 2, 0});
    EXPECT_EQ(possible(named("sliding", LatticeKind::Square), {1, 1, 0}, below), (std::vector<Cell>{{-1, 0, 0}, {1, -1, 0}}));
    EXPECT_EQ(possible(named("pivoting", LatticeKind::Square), {1, 1, 0}, below), (std::vector<Cell>{{1, -1, 0}}));
}

TEST(MoveTable, LeapsOverAGapWithAnotherPivot) {
    const std::set<Cell> gap = {{0, 1, 0}, {0, 0, 0}, {2, 0, 0}};
    const std::vector<Cell> to = possible(named("monkey", LatticeKind::Square), {0, 1, 0}, gap);
    EXPECT_TRUE(std::ranges::count(to, Cell{2, 0, 0}) == 1);
    EXPECT_EQ(std::ranges::count(possible(named("leapfrog", LatticeKind::Square), {0, 1, 0}, gap), Cell{2, 0, 0}), 0);
}

// On the fcc lattice, a catom beside only one other rolls to all of the cells beside that one which touch its own or are across a square.
TEST(MoveTable, RollsAroundOneSphere) {
    const Lattice lattice(LatticeKind::Fcc);
    const MoveTable table = named("rolling", LatticeKind::Fcc);
    for (const Cell pivot : {Cell{}, Cell{5, 3, 1}})
        for (int port = 0; port < lattice.ports(); ++port) {
            const Cell mover = lattice.neighbour(pivot, port);
            std::set<Cell> expected;
            for (int other = 0; other < lattice.ports(); ++other) {
                const Cell end = lattice.neighbour(pivot, other);
                const Vec3 a = lattice.position(mover), b = lattice.position(end);
                const double apart = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
                if (apart > 0.5 && apart < 1.5) expected.insert(end - mover);
            }
            const std::vector<Cell> found = possible(table, mover, {pivot, mover});
            EXPECT_EQ(found, std::vector<Cell>(expected.begin(), expected.end())) << port;
        }
}

TEST(MoveTable, TakesTheFirstMoveThatFits) {
    const MoveTable table = named("sliding", LatticeKind::Square);
    const std::set<Cell> both = {{0, 0, 0}, {0, -1, 0}, {1, -1, 0}, {0, 1, 0}, {1, 1, 0}};
    const auto full = [&](Cell c) { return both.contains(c); };
    const auto found = table.find({}, {1, 0, 0}, full);
    ASSERT_TRUE(found);
    EXPECT_EQ(table.from({})[*found].full, (std::vector<Cell>{{0, -1, 0}, {1, -1, 0}}));
    EXPECT_FALSE(table.find({}, {-1, 0, 0}, full));
    EXPECT_FALSE(table.find({}, {0, 1, 0}, full));
}

TEST(MoveTable, KeepsHandednessIfOnlyRotationsAreAsked) {
    const ListedMove turn{.move = {.by = {1, 0, 0}, .full = {{0, -1, 0}}}, .symmetries = Symmetries::Rotations};
    EXPECT_EQ(MoveTable(LatticeKind::Square, "", {&turn, 1}).from({}).size(), 4u);
    const ListedMove one{.move = turn.move, .symmetries = Symmetries::None};
    EXPECT_EQ(MoveTable(LatticeKind::Square, "", {&one, 1}).from({}).size(), 1u);
    const ListedMove all{.move = turn.move};
    EXPECT_EQ(MoveTable(LatticeKind::Square, "", {&all, 1}).from({}).size(), 8u);
}

}  // namespace
}  // namespace meld::world
