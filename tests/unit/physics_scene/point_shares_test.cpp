#include "physics/statics/point_shares.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace meld::physics {
namespace {

std::vector<double> shares(const std::vector<Vec3>& arms) {
    std::vector<double> found(arms.size());
    shares_of(arms, found);
    return found;
}

Vec3 mean(const std::vector<Vec3>& arms, const std::vector<double>& shares) {
    Vec3 sum;
    for (std::size_t i = 0; i < arms.size(); ++i) sum = sum + shares[i] * arms[i];
    return sum;
}

TEST(PointShares, OfCornersAroundAPlaceAreThoseOfALever) {
    EXPECT_EQ(shares({{3, 4, 5}}), std::vector<double>{1});
    EXPECT_EQ(shares({{}, {}}), (std::vector<double>{0.5, 0.5}));
    for (const double share : shares({{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}})) EXPECT_NEAR(share, 0.25, 1e-9);
    const auto lever = shares({{1, 0, 0}, {-3, 0, 0}});
    EXPECT_NEAR(lever[0], 0.75, 1e-6);
    // Beside all of them: the nearest place between them.
    const auto beside = shares({{1, 1, 0}, {1, -3, 0}, {2, 0, 0}, {3, 1, 0}});
    EXPECT_NEAR(beside[0], 0.75, 1e-6);
    EXPECT_NEAR(beside[1], 0.25, 1e-6);
    EXPECT_EQ(beside[2] + beside[3], 0);
}

// The conditions of Karush, Kuhn and Tucker: a point with a share has the same gradient as all others that have one, and one without a
// share no smaller one.
TEST(PointShares, AreTheMostEvenOnesWhoseMeanIsNearest) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> where(-1, 1);
    for (int scene = 0; scene < 4000; ++scene) {
        const std::size_t count = 1 + random() % 40;
        const Vec3 shift = scene % 3 == 0 ? Vec3{} : Vec3{3 * where(random), 3 * where(random), 0};
        std::vector<Vec3> arms;
        for (std::size_t i = 0; i < count; ++i) {
            // In a plane, on a line, at few places, or anywhere.
            Vec3 arm{where(random), where(random), where(random)};
            if (scene % 4 < 3) arm.z = 0;
            if (scene % 4 == 1) arm.y = 0.3 * arm.x;
            if (scene % 4 == 2) arm = {arm.x > 0 ? 1.0 : -1.0, arm.y > 0 ? 0.5 : -0.5, 0};
            arms.push_back(arm + shift);
        }
        const auto found = shares(arms);
        EXPECT_NEAR(std::accumulate(found.begin(), found.end(), 0.0), 1, 1e-12);
        const Vec3 rest = mean(arms, found);
        double farthest = 0;
        for (const Vec3 arm : arms) farthest = std::max(farthest, dot(arm, arm));
        const double evenness = 1e-7 * farthest,
                     least = dot(rest, rest) + evenness * std::inner_product(found.begin(), found.end(), found.begin(), 0.0);
        for (std::size_t i = 0; i < count; ++i) {
            EXPECT_GE(found[i], 0);
            const double gradient = dot(arms[i], rest) + evenness * found[i];
            EXPECT_GE(gradient, least - 0.5 * evenness) << scene << ", " << i << " of " << count;
            if (found[i] > 0 && count > 1) {
                EXPECT_NEAR(gradient, least, 0.5 * evenness) << scene << ", " << i << " of " << count;
            }
        }
    }
}

}  // namespace
}  // namespace meld::physics
