#include "physics/collision/reach_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace meld::physics {
namespace {

struct Reaching {
    Vec3 place_m;
    double reach_m;
};

ReachGrid grid_of(const std::vector<Reaching>& all) {
    ReachGrid grid;
    for (const auto& [place_m, reach_m] : all) grid.add(place_m, reach_m);
    grid.sort();
    return grid;
}

TEST(ReachGrid, FindsAllThatReachAPointInTheirOrder) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> where(-30, 30), reach(-3, 3);
    std::vector<Reaching> all;
    for (int i = 0; i < 3000; ++i)
        all.push_back({{where(random), where(random), where(random)},
                       i % 100 == 0 ? std::numeric_limits<double>::infinity() : std::exp2(reach(random))});
    const ReachGrid grid = grid_of(all);
    std::vector<std::uint32_t> found;
    std::size_t most = 0;
    for (std::size_t i = 0; i < 500; ++i) {
        // Some on a place, and some exactly as far away as it reaches.
        Vec3 at{where(random), where(random), where(random)};
        if (i % 3 != 0) at = all[i].place_m;
        if (i % 3 == 1 && std::isfinite(all[i].reach_m)) at.y -= all[i].reach_m;
        grid.find(at, found);
        EXPECT_TRUE(std::ranges::is_sorted(found));
        EXPECT_EQ(std::ranges::adjacent_find(found), found.end());
        most = std::max(most, found.size());
        for (std::uint32_t n = 0; n < all.size(); ++n)
            EXPECT_TRUE(length(all[n].place_m - at) > all[n].reach_m || std::ranges::binary_search(found, n)) << n;
    }
    EXPECT_LT(most, 600u);
}

TEST(ReachGrid, TakesPlacesAndReachesOfAllSizes) {
    constexpr double kEndless = std::numeric_limits<double>::infinity();
    const std::vector<Reaching> all = {{{1e300, 0, 0}, 1e-300}, {{0, -1e18, 0}, 5},    {{1, 2, 3}, 1e308},        {{0, 0, 0}, kEndless},
                                       {{-1e-9, 0, 0}, 1e-9},   {{0, -1e18, 0}, 1e-5}, {{1e300, 0, 0}, kEndless}, {{0, 0, 8}, 8}};
    const ReachGrid grid = grid_of(all);
    std::vector<std::uint32_t> found;
    const auto finds = [&](Vec3 at, std::uint32_t number) {
        grid.find(at, found);
        return std::ranges::binary_search(found, number);
    };
    for (std::uint32_t n = 0; n < all.size(); ++n) EXPECT_TRUE(finds(all[n].place_m, n)) << n;
    EXPECT_TRUE(finds({0, 0, 0}, 4));
    EXPECT_TRUE(finds({0, 0, 0}, 7));
    EXPECT_TRUE(finds({0, 0, 16}, 7));
    EXPECT_FALSE(finds({0, 0, 40}, 7));
    grid_of({}).find({}, found);
    EXPECT_TRUE(found.empty());
}

// Lamps and sensors, as many of each, as dense as before in ten and a hundred times the space: how many lamps all sensors look at.
TEST(ReachGrid, LooksAtAsManyPerPointHoweverManyThereAre) {
    constexpr double kReach = 1.9;
    std::vector<double> looks;
    for (const std::size_t count : {300u, 3000u, 30'000u}) {
        std::mt19937 random(5);
        std::uniform_real_distribution<double> where(0, std::cbrt(static_cast<double>(count)));
        std::vector<Reaching> all;
        for (std::size_t i = 0; i < count; ++i) all.push_back({{where(random), where(random), where(random)}, kReach});
        const ReachGrid grid = grid_of(all);
        std::vector<std::uint32_t> found;
        std::size_t sum = 0;
        for (const Reaching& here : all) grid.find(here.place_m, found), sum += found.size();
        looks.push_back(static_cast<double>(sum) / static_cast<double>(count));
        // Hardly more than there are in 27 cells, whose sides are at most twice the reach.
        EXPECT_LT(looks.back(), 1.3 * 27 * std::pow(2 * 1.001, 3));
    }
    // Fewer at the sides of the space, which are a smaller part of a larger one.
    EXPECT_LT(looks[1], 3 * looks[0]);
    EXPECT_LT(looks[2], 1.5 * looks[1]);
}

// What they give at each place, summed up one after the other, has the same bits as without the grid.
TEST(ReachGrid, GivesTheSumsOfAllThatReach) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> where(-20, 20), reach(0.5, 9);
    std::vector<Reaching> all;
    for (int i = 0; i < 4000; ++i) all.push_back({{where(random), where(random), where(random)}, reach(random)});
    const ReachGrid grid = grid_of(all);
    std::vector<std::uint32_t> found;
    for (int i = 0; i < 1000; ++i) {
        const Vec3 at{where(random), where(random), where(random)};
        double with = 0, without = 0;
        const auto add = [&](const Reaching& one, double& sum) {
            if (const double far = length(one.place_m - at); far <= one.reach_m) sum += 1 / (far * far);
        };
        grid.find(at, found);
        for (const std::uint32_t n : found) add(all[n], with);
        for (const Reaching& one : all) add(one, without);
        EXPECT_EQ(with, without);
    }
}

}  // namespace
}  // namespace meld::physics
