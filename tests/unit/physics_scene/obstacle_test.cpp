// Balls on planes, boxes, terrain and meshes, on one and on several workers.
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

// Whatever a step's way is: it hits a wall thinner than that where its way leads, and bounces off as it came.
TEST(Obstacles, FastBallsDoNotPassThinWalls) {
    Workers workers(1);
    for (const double speed : {20.0, 60.0, 150.0, 333.0, 900.0})
        for (const double start : {2.0, 3.7, 6.0, 11.3})
            for (const double restitution : {0.0, 1.0})
                for (const std::string_view wall : {"plane", "box", "mesh", "mesh seen from behind"}) {
                    auto scene = make_scene({.gravity_m_s2 = {}});
                    const std::uint8_t material =
                        need(scene->add_material({.friction = 0, .restitution = static_cast<float>(restitution)}));
                    const Quat turned{std::cos(0.2), 0, 0, std::sin(0.2)};
                    Mesh mesh = square(60, 0.05);
                    if (wall == "plane")
                        need(scene->add_obstacle(Plane{.offset_m = 0.05}, material));
                    else if (wall == "mesh")
                        need(scene->add_obstacle(mesh, material));
                    else if (wall == "mesh seen from behind")
                        std::swap(mesh.triangles[0], mesh.triangles[1]), std::swap(mesh.triangles[3], mesh.triangles[4]),
                            need(scene->add_obstacle(mesh, material));
                    else
                        need(scene->add_obstacle(Box{.size_m = {60, 60, 0.1}, .orientation = turned}, material));
                    need(scene->add_body(
                        {.id = 0, .position_m = {0, 0, start}, .linear_velocity_m_s = {0.4 * speed, 0, -speed}, .material = material}));
                    double nearest = start;
                    for (int tick = 0; tick < static_cast<int>(2 * start / speed / kTick) + 3; ++tick) {
                        need(scene->step(kTick, 2, workers));
                        nearest = std::min(nearest, scene->state(0).position_m.z);
                    }
                    EXPECT_GT(nearest, 0.54) << speed << " from " << start;
                    const Vec3 after = scene->state(0).linear_velocity_m_s;
                    EXPECT_NEAR(after.x, 0.4 * speed, 1e-3 * speed);
                    EXPECT_NEAR(after.z, restitution * speed, 0.01 * speed) << speed << " from " << start << " onto a " << wall;
                }
}

TEST(Obstacles, FastBallsPassBesideThem) {
    Workers workers(1);
    for (const double speed : {150.0, 600.0})
        for (const double start : {3.0, 4.1, 5.2}) {
            auto scene = make_scene({.gravity_m_s2 = {}});
            need(scene->add_obstacle(Box{.size_m = {2, 2, 2}}, 0));
            // Its way leads past the edge, which the nearest point of the box is on, with 5 cm to spare.
            need(scene->add_body({.id = 0, .position_m = {1.55, start, start}, .linear_velocity_m_s = {0, -speed, -speed}}));
            for (int tick = 0; tick < 8; ++tick) need(scene->step(kTick, 2, workers));
            EXPECT_NEAR(scene->state(0).linear_velocity_m_s.z, -speed, 1e-6 * speed);
            EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 0, 1e-6 * speed);
        }
}

TEST(Obstacles, BallsThatBeginDeepInOneAreRefused) {
    auto scene = make_scene();
    need(scene->add_obstacle(Plane{}, 0));
    need(scene->add_obstacle(Box{.centre = {5, 0, 4}, .size_m = {8, 8, 8}}, 0));
    need(scene->add_obstacle(bowl(), 0));
    const auto refused = [&](Vec3 position, std::string_view problem) {
        const auto added = scene->add_body({.id = 7, .position_m = position});
        ASSERT_FALSE(added);
        EXPECT_EQ(added.error().problem, problem);
        EXPECT_TRUE(added.error().suggestion.starts_with("Move it out of there"));
    };
    refused({20, 0, -30}, "body 7 is 30.5 m deep in obstacle 0, a plane, more than 50 % of its diameter");
    refused({6, 0, 5}, "body 7 is 3.5 m deep in obstacle 1, a box, more than 50 % of its diameter");
    refused({-4, 0, 0.1}, "body 7 is 1.16 m deep in obstacle 2, a terrain, more than 50 % of its diameter");
    // Less deep is a contact, and what does not move may be anywhere.
    need(scene->add_body({.id = 0, .position_m = {20, 0, 0.1}}));
    need(scene->add_body({.id = 1, .position_m = {30, 0, -9}, .fixed = true}));
    Workers workers(1);
    run(*scene, 10, 2, workers);
}

TEST(Obstacles, BallsPressedDeepIntoOneEndTheStep) {
    for (const EngineKind engine : {EngineKind::Blocks, EngineKind::Hash}) {
        auto scene = scene_on_plane({.engine = engine});
        for (BodyId id = 2; id < 5; ++id) need(scene->add_body({.id = id, .position_m = {3.0 * id, 0, 0.5}}));
        Workers workers(1);
        run(*scene, 3, 2, workers);
        BodyState state = scene->state(3);
        state.position_m.z = -1;
        need(scene->set_state(3, state));
        const Digest before = scene->digest();
        const auto report = scene->step(kTick, 2, workers);
        ASSERT_FALSE(report);
        EXPECT_EQ(report.error().problem, "step 4: body 3 is 1.5 m deep in obstacle 0, a plane, more than 50 % of its diameter");
        EXPECT_EQ(scene->digest(), before);
    }
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
