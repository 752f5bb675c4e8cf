// Both broadphases against all pairs tried one by one, on scenes with one and several sizes of bodies.
#include "physics/collision/broadphase.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "physics/collision/block_grid.h"
#include "physics/comparison/hash_broadphase.h"

namespace meld::physics {
namespace {

void add(Bodies& bodies, Vec3 p, double radius, bool fixed = false) {
    const auto id = static_cast<BodyId>(bodies.count());
    bodies.add({p.x, p.y, p.z, radius}, {1, 0, 0, 0}, {},
               {.id = id,
                .mass = 1,
                .inertia_factor = 0.4f,
                .material = 0,
                .flags = fixed ? std::uint8_t{kFixed} : std::uint8_t{0},
                .still_ticks = 0});
}

Bodies random_bodies(std::size_t count, double box_m, double least_radius, double largest_radius, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-box_m / 2, box_m / 2), radius(std::log(least_radius), std::log(largest_radius));
    Bodies bodies;
    for (std::size_t i = 0; i < count; ++i)
        add(bodies, {place(random), place(random), place(random)}, std::exp(radius(random)), i % 17 == 0);
    return bodies;
}

std::vector<BodyPair> pairs_by_id(Broadphase& broadphase, Bodies bodies, double reach, int threads) {
    Workers workers(threads);
    const auto found = broadphase.find(bodies, reach, workers);
    EXPECT_TRUE(found) << found.error().message();
    std::vector<BodyPair> pairs;
    for (const auto& list : broadphase.pairs)
        for (const BodyPair pair : list) {
            const auto [a, b] = std::minmax(bodies.properties[pair.first].id, bodies.properties[pair.second].id);
            pairs.push_back({a, b});
        }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

std::vector<BodyPair> all_pairs(const Bodies& bodies, double reach) {
    std::vector<BodyPair> pairs;
    for (std::uint32_t i = 0; i < bodies.count(); ++i)
        for (std::uint32_t j = i + 1; j < bodies.count(); ++j) {
            const Place &p = bodies.place[i], &q = bodies.place[j];
            if ((bodies.properties[i].flags | bodies.properties[j].flags) & kRemoved) continue;
            if (bodies.properties[i].flags & bodies.properties[j].flags & kFixed) continue;
            if (length(Vec3{p.x, p.y, p.z} - Vec3{q.x, q.y, q.z}) < p.radius + q.radius + reach) pairs.push_back({i, j});
        }
    return pairs;
}

struct Case {
    const char* name;
    std::size_t count;
    double box_m, least_radius, largest_radius, reach;
};

class Broadphases : public testing::TestWithParam<Case> {};

TEST_P(Broadphases, FindEachPairOnce) {
    const Case& c = GetParam();
    const Bodies bodies = random_bodies(c.count, c.box_m, c.least_radius, c.largest_radius, 7);
    const std::vector<BodyPair> expected = all_pairs(bodies, c.reach);
    ASSERT_GT(expected.size(), c.count / 4);
    for (const int threads : {1, 2, 4}) {
        EXPECT_EQ(pairs_by_id(*make_block_broadphase(), bodies, c.reach, threads), expected) << threads << " threads";
        EXPECT_EQ(pairs_by_id(*make_hash_broadphase(), bodies, c.reach, threads), expected) << threads << " threads";
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Broadphases,
                         testing::Values(Case{"Equal", 3000, 14, 0.5, 0.5, 0.1}, Case{"TwoLevels", 3000, 20, 0.3, 0.7, 0.05},
                                         Case{"ThreeLevels", 3000, 24, 0.25, 1.0, 0.1}, Case{"BeyondThreeLevels", 2000, 30, 0.1, 2.0, 0.1},
                                         Case{"Sparse", 1500, 60, 1.0, 4.0, 0.5}, Case{"AllInOneCell", 200, 0.5, 0.5, 0.5, 0.1}),
                         [](const auto& test) { return test.param.name; });

TEST(BlockGrid, OrderDependsOnTheWorldAlone) {
    Bodies bodies = random_bodies(5000, 30, 0.3, 0.9, 3), shuffled;
    std::vector<std::uint32_t> order(bodies.count());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), std::mt19937(5));
    for (const std::uint32_t i : order) shuffled.add(bodies.place[i], bodies.orientation[i], bodies.velocity[i], bodies.properties[i]);

    const auto ids_after = [](Bodies& some, int threads) {
        Workers workers(threads);
        BlockGrid grid;
        Buffer<std::uint32_t> former;
        EXPECT_TRUE(grid.build(some, GridShape::fitting(0.3, 0.9, 0.1), 0.1, workers, former));
        std::vector<BodyId> ids;
        for (const BodyProperties& properties : some.properties) ids.push_back(properties.id);
        return ids;
    };
    EXPECT_EQ(ids_after(bodies, 1), ids_after(shuffled, 4));
    for (std::uint32_t slot = 0; slot < bodies.count(); ++slot) EXPECT_EQ(bodies.slot(bodies.properties[slot].id), slot);
}

TEST(BlockGrid, DropsRemovedBodiesAndForgetsTheirIds) {
    Bodies bodies = random_bodies(1000, 10, 0.5, 0.5, 11);
    for (std::size_t i = 0; i < 1000; i += 3) bodies.properties[i].flags |= kRemoved;
    const std::vector<BodyPair> expected = all_pairs(bodies, 0.1);
    EXPECT_EQ(pairs_by_id(*make_block_broadphase(), bodies, 0.1, 2), expected);
    EXPECT_EQ(pairs_by_id(*make_hash_broadphase(), bodies, 0.1, 2), expected);
    Workers workers(1);
    BlockGrid grid;
    Buffer<std::uint32_t> former;
    ASSERT_TRUE(grid.build(bodies, GridShape::fitting(0.5, 0.5, 0.1), 0.1, workers, former));
    EXPECT_EQ(bodies.count(), 666u);
    EXPECT_FALSE(bodies.has(999));
    EXPECT_TRUE(bodies.has(998));
}

TEST(BlockGrid, NamesTheLowestBodyThatIsNowhere) {
    for (const double bad : {std::nan(""), HUGE_VAL, 1e12}) {
        Bodies bodies = random_bodies(100, 10, 0.5, 0.5, 1);
        bodies.place[40].y = bad;
        bodies.place[70].x = bad;
        Workers workers(2);
        BlockGrid grid;
        Buffer<std::uint32_t> former;
        const auto built = grid.build(bodies, GridShape::fitting(0.5, 0.5, 0.1), 0.1, workers, former);
        ASSERT_FALSE(built);
        EXPECT_TRUE(built.error().problem.starts_with("body 40 is at")) << built.error().message();
        EXPECT_EQ(bodies.properties[5].id, 5u);
    }
}

TEST(BlockGrid, KeysHoldNegativeCoordinates) {
    for (const BlockCoordinates c :
         {BlockCoordinates{0, 0, 0}, BlockCoordinates{-1, 2, -3}, BlockCoordinates{kFarthestBlock, -kFarthestBlock, 17}})
        EXPECT_EQ(unpack(pack(c)), c);
    EXPECT_LT(pack({5, 5, -1}), pack({-5, -5, 0}));
}

}  // namespace
}  // namespace meld::physics
