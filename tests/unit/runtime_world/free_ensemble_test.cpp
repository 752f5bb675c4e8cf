#include <gtest/gtest.h>

#include <set>

#include "runtime/world/ensemble/ensemble.h"

namespace meld::world {
namespace {

Ensemble row_of(std::uint64_t count) {
    Ensemble ensemble{Lattice(LatticeKind::Cubic), std::function<bool(Cell)>()};
    ensemble.set_free([](const Vec3& at) { return at[0] > 10; });
    for (std::uint64_t id = 0; id < count; ++id) ensemble.add_at(1000 + id, Vec3{static_cast<double>(id), 0, 0}, kCatomOwned);
    return ensemble;
}

std::set<u64> neighbours(const Ensemble& ensemble, Catom catom) {
    const Geometry g = ensemble.geometry();
    std::set<u64> ids;
    for (i32 port = 0; port < g.ports; ++port)
        if (const i32 other = catom_towards(g, g.catom_site[catom], port); other >= 0) {
            ids.insert(id_of(g, other));
            // The other end sees this one at the port that looks back.
            const i32 back = port_there(g, catom, port);
            EXPECT_EQ(catom_towards(g, g.catom_site[other], back), static_cast<i32>(catom));
        }
    return ids;
}

TEST(FreeEnsemble, ShowsModulesItsLinksAsNeighbours) {
    Ensemble ensemble = row_of(200);
    for (Catom c = 0; c < 200; ++c) EXPECT_TRUE(neighbours(ensemble, c).empty());
    // A row, and one that has as many neighbours as there are ports.
    for (Catom c = 0; c + 1 < 150; ++c) ensemble.link(c, *ensemble.vacant_port(c), c + 1, *ensemble.vacant_port(c + 1));
    for (Catom c = 160; c < 160 + kMaxPorts; ++c) ensemble.link(159, *ensemble.vacant_port(159), c, 11);
    for (Catom c = 1; c + 1 < 150; ++c) EXPECT_EQ(neighbours(ensemble, c), (std::set<u64>{1000u + c - 1, 1000u + c + 1}));
    EXPECT_EQ(neighbours(ensemble, 159).size(), static_cast<std::size_t>(kMaxPorts));
    EXPECT_FALSE(ensemble.vacant_port(159));
    EXPECT_TRUE(neighbours(ensemble, 159 + 30).empty());
    ensemble.unlink(41, *ensemble.port_towards(41, 42));
    EXPECT_EQ(neighbours(ensemble, 41), (std::set<u64>{1040}));
    EXPECT_EQ(neighbours(ensemble, 42), (std::set<u64>{1043}));
    EXPECT_FALSE(ensemble.port_towards(42, 41));
}

TEST(FreeEnsemble, CutsTheLinksOfACatomThatGoes) {
    Ensemble ensemble = row_of(3);
    ensemble.link(0, 3, 1, 0);
    ensemble.link(1, 7, 2, 0);
    ensemble.remove(1);
    EXPECT_TRUE(neighbours(ensemble, 0).empty());
    EXPECT_TRUE(neighbours(ensemble, 2).empty());
    EXPECT_EQ(ensemble.owned_count(), 2u);
    // The next one has its index, and no links.
    EXPECT_EQ(ensemble.add_at(7, Vec3{5, 5, 5}, kCatomOwned), 1u);
    EXPECT_TRUE(neighbours(ensemble, 1).empty());
    EXPECT_EQ(ensemble.find(7), 1u);
    EXPECT_EQ(ensemble.position(1), (Vec3{5, 5, 5}));
}

TEST(FreeEnsemble, KnowsWhoIsInTheTarget) {
    Ensemble ensemble = row_of(20);
    const auto inside = [&](Catom c) { return in_target(ensemble.geometry(), ensemble.geometry().catom_site[c]); };
    for (Catom c = 0; c < 20; ++c) EXPECT_EQ(inside(c), c > 10) << c;
    EXPECT_TRUE(ensemble.place(4, {11, 0, 0}));
    EXPECT_FALSE(ensemble.place(4, {12, 0, 0}));
    EXPECT_TRUE(inside(4));
    EXPECT_TRUE(ensemble.place(4, {3, 0, 0}));
    EXPECT_FALSE(inside(4));
    EXPECT_FALSE(inside(3));
}

}  // namespace
}  // namespace meld::world
