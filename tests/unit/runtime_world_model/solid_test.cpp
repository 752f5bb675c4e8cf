#include "runtime/world/model/solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/unit/runtime_world_model/surfaces.h"

namespace meld::model {
namespace {

TEST(Solid, HoldsHalfOpenBoxes) {
    const Solid box(box_surface({-2, -1, 0}, {2, 1, 3}));
    EXPECT_TRUE(box.closed());
    int inside = 0;
    for (int x = -3; x <= 3; ++x)
        for (int y = -3; y <= 3; ++y)
            for (int z = -3; z <= 4; ++z) {
                const bool expected = x >= -2 && x < 2 && y >= -1 && y < 1 && z >= 0 && z < 3;
                EXPECT_EQ(box.contains({1.0 * x, 1.0 * y, 1.0 * z}), expected) << x << " " << y << " " << z;
                inside += expected;
            }
    EXPECT_EQ(inside, 24);
}

TEST(Solid, AgreesWithTheFormulaAwayFromTheSurface) {
    const std::uint32_t rings = 60;
    const Solid sphere(sphere_surface(10, rings));
    // A flat side of that length is this much nearer to the centre than its corners.
    const double dent = 10 * (1 - std::pow(std::cos(std::numbers::pi / 2 / rings), 2)) + 1e-9;
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> any(-11, 11);
    for (int i = 0; i < 20'000; ++i) {
        const Vec3 p = {any(random), any(random), any(random)};
        const double distance = std::hypot(p[0], p[1], p[2]) - 10;
        if (distance > 0 || distance < -dent) {
            ASSERT_EQ(sphere.contains(p), distance < 0) << distance;
        }
        ASSERT_NEAR(sphere.distance(p), distance, dent);
    }
}

// Whatever is rounded, a row through a closed surface crosses it an even number of times. So from before the model all are outside, and the
// three axes agree; rays in single precision lose some.
TEST(Solid, FindsNoOddRowThroughAClosedSurface) {
    Triangles torus = torus_surface(1.0 / 3, 0.1, 97, 41);
    for (Vec3& p : torus.points)
        p = {0.36 * p[0] + 0.48 * p[1] - 0.8 * p[2] + 0.1, -0.8 * p[0] + 0.6 * p[1] + 0.7, 0.48 * p[0] + 0.64 * p[1] + 0.6 * p[2]};
    // A solid whose surface is the torus and one triangle that lies far away has open edges, so it is asked along each axis and counts.
    const Solid closed(torus);
    EXPECT_TRUE(closed.closed());
    const auto first = static_cast<std::uint32_t>(torus.points.size());
    Triangles with = torus;
    for (const Vec3& p : {Vec3{90, 90, 90}, Vec3{90, 91, 90}, Vec3{90, 90, 91}}) with.points.push_back(p);
    with.corners.push_back({first, first + 1, first + 2});
    const Solid open(with);
    EXPECT_EQ(open.openness().open_edges, 3u);
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> any(-0.5, 1.2);
    for (int i = 0; i < 50'000; ++i) {
        Vec3 p = {any(random), any(random), any(random)};
        // Rows through corners and edges are the hard ones.
        if (i % 2 == 0) p[1] = torus.points[static_cast<std::size_t>(i) % torus.points.size()][1];
        if (i % 4 == 0) p[2] = torus.points[static_cast<std::size_t>(i) % torus.points.size()][2];
        ASSERT_EQ(closed.contains(p), open.contains(p));
        p[0] = closed.low()[0] - 1e-12;
        ASSERT_FALSE(closed.contains(p));
    }
}

TEST(Solid, CountsHolesAndGoesOnByMajority) {
    Triangles sphere = sphere_surface(10, 24);
    const std::size_t whole = sphere.corners.size();
    // A hole at the top: rows along z through it say outside, the others inside.
    std::erase_if(sphere.corners, [](const auto& c) { return c[0] == 1 || c[1] == 1 || c[2] == 1; });
    EXPECT_EQ(whole - sphere.corners.size(), 48u);
    const Solid open(sphere);
    EXPECT_EQ(open.openness().open_edges, 48u);
    EXPECT_GT(open.openness().odd_rows, 0u);
    EXPECT_LT(open.openness().odd_rows, open.openness().rows / 20);
    EXPECT_TRUE(open.contains({0.1, 0.2, 0.3}));
    EXPECT_FALSE(open.contains({0.1, 0.2, -10.5}));
}

TEST(Solid, GivesTheDistanceOfTheNearestTriangle) {
    const Triangles torus = torus_surface(10, 3, 20, 9);
    const Solid solid(torus);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> any(-15, 15);
    for (int i = 0; i < 200; ++i) {
        const Vec3 p = {any(random), any(random), any(random) / 3};
        double least = 1e300;
        for (const auto& corners : torus.corners) {
            // The slow way: many points of each triangle.
            for (int u = 0; u <= 40; ++u) {
                for (int v = 0; u + v <= 40; ++v) {
                    double square = 0;
                    for (std::size_t k = 0; k < 3; ++k) {
                        const double at = (torus.points[corners[0]][k] * (40 - u - v) + torus.points[corners[1]][k] * u +
                                           torus.points[corners[2]][k] * v) /
                                          40;
                        square += (at - p[k]) * (at - p[k]);
                    }
                    least = std::min(least, square);
                }
            }
        }
        const double exact = std::abs(solid.distance(p));
        ASSERT_LE(exact, std::sqrt(least) + 1e-12);
        ASSERT_GE(exact, std::sqrt(least) - 0.15);
    }
}

}  // namespace
}  // namespace meld::model
