#include "runtime/world/lattice/lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <sstream>
#include <string>

namespace meld::world {
namespace {

class EachLattice : public testing::TestWithParam<LatticeKind> {
  protected:
    const Lattice lattice{GetParam()};

    // Random cells, mostly near the origin, where signs change.
    std::vector<Cell> some_cells() const {
        std::mt19937 random(1);
        std::vector<Cell> cells;
        for (int i = 0; i < 500; ++i) {
            const int reach = i % 5 == 0 ? kCellLimit - 40 : 20;
            std::uniform_int_distribution<int> coordinate(-reach, reach);
            cells.push_back({coordinate(random), coordinate(random), lattice.flat() ? 0 : coordinate(random)});
        }
        return cells;
    }
};

double apart(const Vec3& a, const Vec3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

TEST_P(EachLattice, LooksBackOverTheOppositePort) {
    for (const Cell cell : some_cells()) {
        for (int port = 0; port < lattice.ports(); ++port) {
            EXPECT_EQ(lattice.neighbour(lattice.neighbour(cell, port), lattice.opposite(port)), cell) << port;
            EXPECT_EQ(lattice.opposite(lattice.opposite(port)), port);
        }
    }
}

TEST_P(EachLattice, HasDistinctNeighboursAtOneDiameter) {
    for (const Cell cell : some_cells()) {
        std::set<Cell> neighbours;
        for (int port = 0; port < lattice.ports(); ++port) {
            const Cell there = lattice.neighbour(cell, port);
            neighbours.insert(there);
            EXPECT_NEAR(apart(lattice.position(cell), lattice.position(there)), 1, 1e-9);
        }
        EXPECT_EQ(neighbours.size(), static_cast<std::size_t>(lattice.ports()));
    }
}

TEST_P(EachLattice, KeepsADirectionPerPort) {
    for (int port = 0; port < lattice.ports(); ++port) {
        const Vec3 first = lattice.position(lattice.neighbour({}, port));
        for (const Cell cell : some_cells()) {
            const Vec3 from = lattice.position(cell), to = lattice.position(lattice.neighbour(cell, port));
            EXPECT_NEAR(apart({to[0] - from[0], to[1] - from[1], to[2] - from[2]}, first), 0, 1e-9);
        }
    }
}

TEST_P(EachLattice, SplitsCellsIntoBricksAndBack) {
    for (const Cell cell : some_cells()) {
        const Cell brick = lattice.brick_of(cell);
        EXPECT_EQ(lattice.cell_in_brick(brick, lattice.number_in_brick(cell)), cell);
        EXPECT_EQ(lattice.brick_at(lattice.brick_key(brick)), brick);
        EXPECT_EQ(lattice.cell_at(lattice.key(cell)), cell);
        EXPECT_EQ(lattice.brick_of(lattice.brick_origin(brick)), brick);
    }
}

TEST_P(EachLattice, StepsAsItsNeighboursSay) {
    for (const Cell cell : some_cells()) {
        for (int port = 0; port < lattice.ports(); ++port) {
            const Cell there = lattice.neighbour(cell, port);
            const u16 entry = lattice.step_table()[static_cast<std::size_t>(port) * kBrickCells + lattice.number_in_brick(cell)];
            EXPECT_EQ(lattice.number_in_brick(there), entry & (kBrickCells - 1));
            EXPECT_EQ(lattice.brick_of(there), lattice.brick_of(cell) + Lattice::brick_offset(entry >> kBrickCellBits));
        }
    }
}

TEST_P(EachLattice, CoversABoxByItsCells) {
    const Vec3 low = {-7.3, -5.1, -4.2}, high = {9.4, 3.3, 6.6};
    Cell first, last;
    lattice.cells_covering(low, high, first, last);
    for (const Cell cell : some_cells()) {
        const Vec3 p = lattice.position(cell);
        const bool inside = p[0] >= low[0] && p[0] <= high[0] && p[1] >= low[1] && p[1] <= high[1] && p[2] >= low[2] && p[2] <= high[2];
        if (!inside) continue;
        EXPECT_TRUE(cell.x > first.x && cell.y > first.y && cell.x < last.x && cell.y < last.y);
        EXPECT_TRUE(lattice.flat() || (cell.z > first.z && cell.z < last.z));
    }
    Vec3 around_low, around_high;
    lattice.positions_covering({-3, -4, 0}, {5, 6, 0}, around_low, around_high);
    for (int x = -3; x <= 5; ++x) {
        for (int y = -4; y <= 6; ++y) {
            const Vec3 p = lattice.position({x, y, 0});
            for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(p[i] >= around_low[i] && p[i] <= around_high[i]);
        }
    }
}

TEST_P(EachLattice, IsFoundByItsName) {
    EXPECT_EQ(Lattice::kind_named(lattice.name()), lattice.kind());
    EXPECT_EQ(Lattice::kind_named("free"), std::nullopt);
}

INSTANTIATE_TEST_SUITE_P(Lattices, EachLattice,
                         testing::Values(LatticeKind::Square, LatticeKind::Hex, LatticeKind::Cubic, LatticeKind::Fcc),
                         [](const auto& kind) { return std::string(Lattice(kind.param).name()); });

// "bottom" leads down, whatever its number.
bool leads(std::string_view word, const Vec3& step) {
    const std::pair<std::string_view, std::pair<std::size_t, int>> ways[] = {{"east", {0, 1}},   {"right", {0, 1}}, {"west", {0, -1}},
                                                                             {"left", {0, -1}},  {"north", {1, 1}}, {"back", {1, 1}},
                                                                             {"south", {1, -1}}, {"front", {1, -1}}};
    for (const auto& [name, way] : ways)
        if (word == name) return step[way.first] * way.second > 0.1;
    const bool flat = std::abs(step[2]) < 0.1;
    if (word == "side") return flat;
    // In the plane, up is north.
    return (word == "top" || word == "up" ? 1 : -1) * (flat ? step[1] : step[2]) > 0.1;
}

TEST(PortNumbers, LeadWhereTheirWordsSay) {
    std::vector<PortNumbers> all(lattice_port_numbers().begin(), lattice_port_numbers().end());
    all.insert(all.end(), robot_port_numbers().begin(), robot_port_numbers().end());
    for (const PortNumbers& numbers : all) {
        const LatticeKind kind = Lattice::kind_named(numbers.lattice).value();
        const bool own = numbers.name == kLatticePorts;
        const Lattice plain(kind), lattice(kind, own ? nullptr : &numbers);
        ASSERT_EQ(numbers.count, plain.ports()) << numbers.name;
        std::set<int> used;
        for (int port = 0; port < lattice.ports(); ++port) {
            const Side& side = numbers.sides[static_cast<std::size_t>(port)];
            EXPECT_TRUE(used.insert(side.port).second) << numbers.name << " " << port;
            if (own) {
                EXPECT_EQ(side.port, port);
            }
            EXPECT_EQ(lattice.own_number(port), side.port);
            for (const Cell cell : {Cell{}, Cell{3, -2, 0}, Cell{0, 0, 1}, Cell{1, 1, -1}}) {
                if (lattice.flat() && cell.z != 0) continue;
                EXPECT_EQ(lattice.neighbour(cell, port), plain.neighbour(cell, side.port));
                EXPECT_EQ(lattice.neighbour(lattice.neighbour(cell, port), lattice.opposite(port)), cell);
                const Vec3 from = lattice.position(cell), to = lattice.position(lattice.neighbour(cell, port));
                std::string words(side.words);
                std::ranges::replace(words, '-', ' ');
                std::istringstream in(words);
                for (std::string word; in >> word;)
                    EXPECT_TRUE(leads(word, {to[0] - from[0], to[1] - from[1], to[2] - from[2]}))
                        << numbers.name << " " << port << " " << word;
            }
            EXPECT_EQ(lattice.step_table()[static_cast<std::size_t>(port) * kBrickCells],
                      plain.step_table()[static_cast<std::size_t>(side.port) * kBrickCells]);
        }
        EXPECT_EQ(port_numbers_of(numbers.name) == nullptr, own);
    }
    EXPECT_EQ(port_numbers_of("blinky")->table(), "0 bottom, 1 north, 2 east, 3 west, 4 south, 5 top");
}

TEST(FccLattice, HasLayersOfTwelveNeighbours) {
    const Lattice fcc(LatticeKind::Fcc);
    EXPECT_NEAR(fcc.position({0, 0, 1})[2], std::sqrt(0.5), 1e-12);
    EXPECT_EQ(fcc.neighbour({0, 0, 0}, 4), (Cell{0, 0, 1}));
    EXPECT_EQ(fcc.neighbour({0, 0, 1}, 4), (Cell{1, 1, 2}));
    EXPECT_EQ(fcc.neighbour({0, 0, -1}, 10), (Cell{0, 0, -2}));
}

}  // namespace
}  // namespace meld::world
