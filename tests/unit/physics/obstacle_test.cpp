// Balls on planes, boxes, terrain and meshes, through ODE's collision, on one and on several workers.
#include <gtest/gtest.h>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

Terrain bowl() {
    Terrain terrain{.origin = {-5, -5, 0}, .cell_m = 0.5, .columns = 21, .rows = 21};
    for (int row = 0; row < 21; ++row)
        for (int column = 0; column < 21; ++column) {
            const double x = -5 + 0.5 * column, y = -5 + 0.5 * row;
            terrain.heights_m.push_back(0.05 * x * x + 0.1 * y * y);
        }
    return terrain;
}

Mesh square(double half, double z) {
    return {.points = {{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}}, .triangles = {0, 1, 2, 0, 2, 3}};
}

TEST(Obstacles, BallRestsOnABoxWhereverItStands) {
    auto scene = make_scene();
    need(scene->add_obstacle(Box{.centre = {1, 2, 3}, .size_m = {2, 2, 1}, .orientation = {std::cos(0.3), 0, 0, std::sin(0.3)}}, 0));
    need(scene->add_body({.id = 0, .position_m = {1.2, 2.1, 4.05}}));
    need(scene->add_body({.id = 1, .position_m = {5, 5, 4.05}}));
    Workers workers(1);
    run(*scene, 120, 2, workers);
    EXPECT_NEAR(scene->state(0).position_m.z, 4, 2e-3);
    EXPECT_LT(scene->state(1).position_m.z, 3);
}

TEST(Obstacles, BallRollsDownATiltedBox) {
    const double angle = 0.3;
    auto scene = make_scene();
    need(scene->add_obstacle(
        Box{.centre = {0, 0, 0}, .size_m = {40, 4, 1}, .orientation = {std::cos(angle / 2), 0, std::sin(angle / 2), 0}}, 0));
    const Vec3 up{std::sin(angle), 0, std::cos(angle)};
    need(scene->add_body({.id = 0, .position_m = 1.0 * up}));
    Workers workers(1);
    run(*scene, 240, 2, workers);
    EXPECT_NEAR(speed(*scene, 0), 5.0 / 7 * 9.81 * std::sin(angle), 0.02);
}

TEST(Obstacles, BallSettlesInTheMiddleOfABowl) {
    for (const int threads : {1, 2}) {
        auto scene = make_scene({.linear_damping_per_s = 0.5, .angular_damping_per_s = 2});
        need(scene->add_obstacle(bowl(), 0));
        need(scene->add_body({.id = 0, .position_m = {2, 1.5, 1.5}, .radius_m = 0.4}));
        need(scene->add_body({.id = 1, .position_m = {-3, -1, 2}, .radius_m = 0.3}));
        Workers workers(threads);
        run(*scene, 2400, 2, workers);
        const Vec3 p = scene->state(0).position_m;
        EXPECT_LT(std::abs(p.x), 0.7) << threads;
        EXPECT_LT(std::abs(p.y), 0.5) << threads;
        EXPECT_GT(p.z, 0.35);
        EXPECT_LT(p.z, 0.55);
        EXPECT_LT(speed(*scene, 0), 0.1);
    }
}

// Heights run with x and then y: a slope that rises along x, seen from the balls on it.
TEST(Obstacles, TerrainStandsTheRightWay) {
    auto scene = make_scene();
    Terrain terrain{.origin = {10, 20, 1}, .cell_m = 1, .columns = 5, .rows = 3};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 5; ++column) terrain.heights_m.push_back(row == 2 ? 2 : 0.0 * column);
    need(scene->add_obstacle(terrain, 0));
    need(scene->add_body({.id = 0, .position_m = {12, 20.4, 1.45}, .radius_m = 0.4, .fixed = false}));
    need(scene->add_body({.id = 1, .position_m = {12, 21.95, 3.5}, .radius_m = 0.2}));
    Workers workers(1);
    run(*scene, 60, 2, workers);
    EXPECT_NEAR(scene->state(0).position_m.z, 1.4, 0.02);
    EXPECT_GT(scene->state(1).position_m.z, 2.5);
}

TEST(Obstacles, BallRestsOnAMesh) {
    auto scene = make_scene();
    need(scene->add_obstacle(square(3, 1), 0));
    need(scene->add_body({.id = 0, .position_m = {0.3, -0.4, 1.55}}));
    Workers workers(2);
    run(*scene, 120, 2, workers);
    EXPECT_NEAR(scene->state(0).position_m.z, 1.5, 3e-3);
    EXPECT_FALSE(scene->contacts().empty());
}

TEST(Obstacles, ImpossibleOnesAreRefusedWithTheReason) {
    auto scene = make_scene();
    EXPECT_FALSE(scene->add_obstacle(Plane{.normal = {0, 0, 0}}, 0));
    EXPECT_FALSE(scene->add_obstacle(Plane{.offset_m = std::nan("")}, 0));
    EXPECT_FALSE(scene->add_obstacle(Box{.size_m = {1, 0, 1}}, 0));
    EXPECT_FALSE(scene->add_obstacle(Box{.orientation = {0, 0, 0, 0}}, 0));
    EXPECT_FALSE(scene->add_obstacle(Terrain{.columns = 2, .rows = 2, .heights_m = {1, 2, 3}}, 0));
    EXPECT_FALSE(scene->add_obstacle(Terrain{.columns = 2, .rows = 2, .heights_m = {1, 2, 3, HUGE_VAL}}, 0));
    EXPECT_FALSE(scene->add_obstacle(Mesh{.points = {{0, 0, 0}}, .triangles = {0, 0, 1}}, 0));
    EXPECT_FALSE(scene->add_obstacle(Plane{}, 7));
    const auto wrong = scene->add_obstacle(Terrain{.columns = 2, .rows = 2, .heights_m = {1}}, 0);
    EXPECT_EQ(wrong.error().problem, "the terrain has 1 heights, not 2 x 2");
}

}  // namespace
}  // namespace meld::physics
