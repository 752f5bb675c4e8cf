// The places of catoms in a snapshot, as bytes and back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "runtime/sim/state/cell_places.h"
#include "runtime/sim/state/free_places.h"
#include "runtime/sim/state/share.h"

namespace meld::sim {
namespace {

using world::Cell;

std::string problem_of(const ByteWriter& bytes) {
    ByteReader in(bytes.view(), "places", ByteReader::Origin::Outside);
    const Result<CellPlaces> read = CellPlaces::read(in);
    return read ? "" : read.error().problem;
}

ByteWriter runs(const std::vector<CellPlaces::Run>& all) {
    ByteWriter out;
    out.write_count(all.size());
    for (const CellPlaces::Run& run : all) {
        out.write(run.first);
        out.write(run.id);
        out.write(run.count);
    }
    return out;
}

TEST(CellPlaces, AreRunsThatGoOverBricksAndComeBackBrickByBrick) {
    const world::Lattice lattice(world::LatticeKind::Cubic);
    world::Ensemble ensemble(lattice, std::function<bool(Cell)>());
    // Two whole bricks that follow each other on the curve, and two catoms with numbers that do not.
    const world::BrickKey brick = lattice.brick_key({0, 0, 0});
    std::vector<world::Catom> catoms;
    for (std::uint64_t i = 0; i < 2 * std::uint64_t{kBrickCells}; ++i)
        catoms.push_back(ensemble.add(10 + i, lattice.cell_at((brick << kBrickCellBits) + i), kCatomOwned));
    catoms.push_back(ensemble.add(5, {100, 100, 100}, kCatomOwned));
    catoms.push_back(ensemble.add(7, {101, 100, 100}, kCatomOwned));
    ByteWriter out;
    CellPlaces::save(ensemble, catoms, out);
    EXPECT_EQ(out.size(), 4 + 3 * 20);
    ByteReader in(out.view(), "places", ByteReader::Origin::Outside);
    const Result<CellPlaces> read = CellPlaces::read(in);
    ASSERT_TRUE(read && in.done());
    std::size_t parts = 0, at = 0;
    ASSERT_TRUE(read->each_in_brick([&](const CellPlaces::Run& part) -> Result<void> {
        ++parts;
        EXPECT_LE((part.first & (kBrickCells - 1)) + part.count, kBrickCells);
        for (std::uint32_t i = 0; i < part.count; ++i, ++at) {
            EXPECT_EQ(part.id + i, ensemble.id(catoms[at]));
            EXPECT_EQ(part.first + i, ensemble.key_of(catoms[at]));
        }
        return {};
    }));
    EXPECT_EQ(parts, 4U);
    EXPECT_EQ(at, catoms.size());
}

TEST(CellPlaces, ThatCannotBeAreRefused) {
    const world::CellKey end = world::CellKey{1} << 63;
    EXPECT_EQ(problem_of(runs({{end - 3, 0, 3}})), "");
    EXPECT_THAT(problem_of(runs({{end - 3, 0, 4}})), testing::HasSubstr("has 4 catoms from cell"));
    EXPECT_THAT(problem_of(runs({{~std::uint64_t{0}, 0, 1}})), testing::HasSubstr("has 1 catoms"));
    EXPECT_THAT(problem_of(runs({{0, 0, 0}})), testing::HasSubstr("has 0 catoms"));
    EXPECT_EQ(problem_of(runs({{0, 0, kMostCatomsOfAChunk - 1}, {0, 0, 1}})), "");
    EXPECT_THAT(problem_of(runs({{0, 0, kMostCatomsOfAChunk - 1}, {0, 0, 2}})), testing::HasSubstr("after 65535 others"));
}

TEST(FreePlaces, KeepEachLinkOnceAndRefuseWhatCannotBe) {
    world::Ensemble ensemble(world::Lattice(world::LatticeKind::Cubic), std::function<bool(Cell)>{});
    ensemble.set_free({});
    const std::vector<world::Catom> catoms = {ensemble.add_at(4, {}, kCatomOwned), ensemble.add_at(2, {}, kCatomOwned),
                                              ensemble.add_at(9, {}, kCatomOwned)};
    ensemble.link(catoms[0], 3, catoms[1], 5);
    ensemble.link(catoms[0], 4, catoms[2], 0);
    const std::vector<world::BrickKey> homes = {77, 77, 80};
    ByteWriter out;
    FreePlaces::save(ensemble, std::nullopt, catoms, homes, out);
    ByteReader in(out.view(), "places", ByteReader::Origin::Outside);
    const Result<FreePlaces> read = FreePlaces::read(in);
    ASSERT_TRUE(read && in.done());
    EXPECT_THAT(read->ids(), testing::ElementsAre(4, 2, 9));
    ASSERT_EQ(read->homes().size(), 2U);
    EXPECT_EQ(read->homes()[0].count, 2U);
    ASSERT_EQ(read->links(0).size(), 1U);
    EXPECT_EQ(read->links(0)[0].other, 9U);
    EXPECT_EQ(read->links(0)[0].port, 4);
    ASSERT_EQ(read->links(1).size(), 1U);
    EXPECT_EQ(read->links(1)[0].other, 4U);
    EXPECT_EQ(read->links(1)[0].port, 5);
    EXPECT_EQ(read->links(1)[0].port_there, 3);
    EXPECT_TRUE(read->links(2).empty());
    // Ended anywhere, it is refused.
    for (std::size_t size = 0; size < out.size(); ++size) {
        ByteReader part(out.view().first(size), "places", ByteReader::Origin::Outside);
        EXPECT_FALSE(FreePlaces::read(part) && part.done() && !part.failed()) << size;
    }
}

}  // namespace
}  // namespace meld::sim
