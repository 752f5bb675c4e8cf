#include "runtime/show/view/kept/cell_box.h"

#include <gtest/gtest.h>

#include <set>

namespace meld::view {
namespace {

using world::Cell;
using world::Lattice;
using world::LatticeKind;

class EachLattice : public testing::TestWithParam<LatticeKind> {};

TEST_P(EachLattice, GivesEachCellANumberOfItsOwn) {
    const Lattice lattice(GetParam());
    const int height = lattice.flat() ? 0 : 3;
    CellBox box(GetParam());
    EXPECT_TRUE(box.grow(box.bounds_of({-3, -5, -height}, {4, 2, height})));
    std::set<std::uint32_t> numbers;
    for (int z = -height; z <= height; ++z)
        for (int y = -5; y <= 2; ++y)
            for (int x = -3; x <= 4; ++x) {
                const std::uint32_t number = box.number({x, y, z});
                EXPECT_LT(number, box.size());
                EXPECT_TRUE(numbers.insert(number).second);
                EXPECT_EQ(box.cell(number), (Cell{x, y, z}));
            }
}

TEST_P(EachLattice, LeadsToTheSameNeighboursFromEveryCell) {
    const Lattice lattice(GetParam());
    CellBox box(GetParam());
    box.grow(box.bounds_of({-2, -2, lattice.flat() ? 0 : -2}, {2, 2, lattice.flat() ? 0 : 2}));
    const std::vector<std::ptrdiff_t> ways = box.ways(lattice);
    for (const Cell cell : {Cell{0, 0, 0}, Cell{-1, 1, lattice.flat() ? 0 : 1}, Cell{1, -1, lattice.flat() ? 0 : -1}})
        for (int port = 0; port < lattice.ports(); ++port)
            EXPECT_EQ(box.number(lattice.neighbour(cell, port)), box.number(cell) + ways[static_cast<std::size_t>(port)]);
}

TEST(CellBox, KeepsItsNumbersUntilItGrows) {
    CellBox box(LatticeKind::Cubic);
    EXPECT_TRUE(box.grow(box.bounds_of({0, 0, 0}, {7, 7, 7})));
    const std::uint32_t before = box.number({1, 2, 3});
    EXPECT_FALSE(box.grow(box.bounds_of({2, 2, 2}, {5, 5, 5})));
    EXPECT_FALSE(box.grow({}));
    EXPECT_EQ(box.number({1, 2, 3}), before);
    EXPECT_TRUE(box.grow(box.bounds_of({-1, 0, 0}, {7, 7, 7})));
    EXPECT_EQ(box.cell(box.number({1, 2, 3})), (Cell{1, 2, 3}));
}

INSTANTIATE_TEST_SUITE_P(Lattices, EachLattice,
                         testing::Values(LatticeKind::Square, LatticeKind::Hex, LatticeKind::Cubic, LatticeKind::Fcc));

}  // namespace
}  // namespace meld::view
