// Obstacles of all kinds that swing, tilt and turn, against mechanics; and the same bits in parts and through snapshots.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/physics/divided_world.h"
#include "tests/unit/physics/scenes.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics::moving {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

std::vector<Settings> all_engines(Vec3 gravity = {0, 0, -kGravity}) {
    Settings pgs = settings_with(gravity), ode = pgs;
    pgs.solver = SolverSettings::pgs20();
    ode.engine = EngineKind::Ode;
    return {settings_with(gravity), pgs, ode};
}

Terrain flat_terrain() { return {{-6, -6, 0}, 2, 7, 7, std::vector<double>(49, 0)}; }
Mesh flat_mesh(double half = 6) { return {{{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}}, {0, 1, 2, 0, 2, 3}}; }
// Whose tops are all z = 0.
std::vector<Shape> flat_tops() {
    const PlacedCompound slab =
        compound_of({{.core_m = {5, 5, 0.4}, .rounding_m = 0.1}, {.core_m = {1, 1, 1}, .rounding_m = 0.1, .at_m = {0, 0, -1}}});
    return {Plane{},
            Box{{0, 0, -0.5}, {12, 12, 1}},
            flat_terrain(),
            flat_mesh(),
            Solid{box_shape({12, 12, 1}, 0.05), {0, 0, -0.5}},
            Solid{cylinder_shape(6, 1, 0), {0, 0, -0.5}},
            Solid{slab.shape, Vec3{0, 0, -0.5} + slab.centre_m}};
}

// A tube of so many sides along y, open at its ends.
Mesh tube(double radius, double half_length, int sides) {
    Mesh mesh;
    for (int i = 0; i < sides; ++i)
        for (const double y : {-half_length, half_length}) {
            const double angle = kTurn * i / sides;
            mesh.points.push_back({radius * std::sin(angle), y, radius * std::cos(angle)});
        }
    const auto n = static_cast<std::uint32_t>(2 * sides);
    for (std::uint32_t i = 0; i < n; i += 2)
        for (const std::uint32_t corner : {i, i + 1, (i + 2) % n, i + 1, (i + 3) % n, (i + 2) % n}) mesh.triangles.push_back(corner);
    return mesh;
}

class MovingObstacles : public testing::Test {
  protected:
    Workers workers_{1};
};

// A cube on something that swings to and fro stays where it is on it as long as friction can hold it.
TEST_F(MovingObstacles, ACubeSlipsOnWhatSwingsFasterThanFrictionHolds) {
    for (const Settings& settings : all_engines())
        for (const Shape& shape : flat_tops())
            for (const double share : {0.85, 1.6}) {
                auto scene = make_scene(settings);
                const auto material = need(scene->add_material({.friction = 0.3f}));
                const auto obstacle = need(scene->add_obstacle(shape, material));
                const double rate = kTurn * 1.5, amplitude = share * 0.3 * kGravity / (rate * rate);
                // From rest.
                need(scene->move_obstacle(obstacle, {.swing_m = {amplitude, 0, 0}, .frequency_hz = 1.5, .phase_rad = kTurn / 4}));
                need(scene->add_body(
                    {.id = 0, .position_m = {1.4, 0.3, 0.25}, .material = material, .shape = box_shape({0.5, 0.5, 0.5}, 0)}));
                double slipped = 0;
                for (int tick = 1; tick <= 320; ++tick) {
                    run(*scene, 1, 2, workers_);
                    const double swung = amplitude * (std::cos(rate * tick * kTick) - 1);
                    slipped = std::max(slipped, std::abs(scene->state(0).position_m.x - 1.4 - swung));
                }
                const std::string where(scene->obstacles().kind(obstacle));
                EXPECT_TRUE(share < 1 ? slipped < 0.012 : slipped > 0.02) << where << static_cast<int>(settings.engine) << " " << slipped;
                EXPECT_NEAR(scene->state(0).position_m.z, 0.25, 0.01) << where;
            }
}

// A plate that shakes with 2 g lets a ball go where it slows down with more than g: at 120 degrees, with 0.87 of its greatest speed.
TEST_F(MovingObstacles, APlateThrowsABallAboveG) {
    for (const Settings& settings : all_engines())
        for (const Shape& shape : flat_tops())
            for (const double share : {0.8, 2.0}) {
                auto scene = make_scene(settings);
                const auto obstacle = need(scene->add_obstacle(shape, 0));
                const double rate = kTurn * 1.2, amplitude = share * kGravity / (rate * rate);
                need(scene->move_obstacle(obstacle, {.swing_m = {0, 0, amplitude}, .frequency_hz = 1.2, .phase_rad = -kTurn / 4}));
                need(scene->add_body({.id = 0, .position_m = {0.3, 0.4, 0.5}}));
                double highest = 0;
                for (int tick = 1; tick <= 200; ++tick) {
                    run(*scene, 1, 2, workers_);
                    highest = std::max(highest, scene->state(0).position_m.z - 0.5);
                    EXPECT_FALSE(scene->asleep(0));
                }
                const double parting = share < 1 ? kTurn / 2 : std::acos(-1 / share), speed = amplitude * rate * std::sin(parting);
                const double expected = amplitude * (1 - std::cos(parting)) + speed * speed / (2 * kGravity);
                EXPECT_NEAR(highest, expected, 0.03 * expected)
                    << scene->obstacles().kind(obstacle) << " " << static_cast<int>(settings.engine) << " " << share;
            }
}

// A block on something that tilts slides as soon as the slope is steeper than friction holds: 16.7 degrees.
TEST_F(MovingObstacles, ABlockSlidesOnWhatTilts) {
    for (const Settings& settings : all_engines())
        for (const Shape& shape : flat_tops()) {
            auto scene = make_scene(settings);
            const auto material = need(scene->add_material({.friction = 0.3f}));
            const auto obstacle = need(scene->add_obstacle(shape, material));
            need(scene->move_obstacle(obstacle, {.tilt_rad = {0, kTurn / 12, 0}, .frequency_hz = 0.1, .pivot_m = Vec3{}}));
            need(scene->add_body({.id = 0, .position_m = {0, 0, 0.25}, .material = material, .shape = box_shape({0.5, 0.5, 0.5}, 0)}));
            const auto time_of = [](double degrees) { return std::asin(degrees / 30) / (kTurn * 0.1); };
            const auto along = [&] { return scene->obstacles().frame(obstacle).into(scene->state(0).position_m).x; };
            const std::string where = std::string(scene->obstacles().kind(obstacle)) + std::to_string(static_cast<int>(settings.engine));
            run(*scene, static_cast<int>(time_of(16) / kTick), 2, workers_);
            EXPECT_NEAR(along(), 0, 0.02) << where;
            run(*scene, static_cast<int>((time_of(22) - time_of(16)) / kTick), 2, workers_);
            EXPECT_NEAR(along(), 0.022, 0.008) << where;
        }
}

// In a drum that turns, a block slides where the slope is that of friction, and a ball rolls at the bottom as fast as the wall. Air
// stops them from swinging about these places.
TEST_F(MovingObstacles, ADrumTakesUpABlockAndTurnsABall) {
    for (Settings settings : all_engines()) {
        settings.linear_damping_per_s = 2;
        auto scene = make_scene(settings);
        const auto material = need(scene->add_material({.friction = 0.3f}));
        const auto drum = need(scene->add_obstacle(tube(3, 2, 180), material));
        need(scene->move_obstacle(drum, {.spin_rad_s = {0, -1, 0}}));
        need(scene->add_body({.id = 0, .position_m = {0, 1, -2.85}, .material = material, .shape = box_shape({0.2, 0.2, 0.2}, 0)}));
        need(scene->add_body({.id = 1, .position_m = {0, -1, -2.6}, .radius_m = 0.4, .material = material}));
        run(*scene, 1200, 2, workers_);
        const auto slope = [&](BodyId id) {
            const Vec3 at = scene->state(id).position_m;
            return std::atan2(at.x, -at.z) * 360 / kTurn;
        };
        EXPECT_NEAR(slope(0), 16.7, 2) << static_cast<int>(settings.engine);
        EXPECT_NEAR(slope(1), 0, 1) << static_cast<int>(settings.engine);
        EXPECT_NEAR(scene->state(1).angular_velocity_rad_s.y, -3 / 0.4, 0.15) << static_cast<int>(settings.engine);
    }
}

// Something that moves without end: for a second it has about this speed.
PrescribedMotion steady(double speed) { return {.swing_m = {8 * speed, 0, 0}, .frequency_hz = 1 / (8 * kTurn)}; }
double speed_at(double speed, double time_s) { return speed * std::cos(time_s / 8); }

// A wall, its face at x = 0.
std::vector<Shape> walls(double half = 2) {
    return {Plane{{1, 0, 0}, 0}, Box{{-0.25, 0, 0}, {0.5, 2 * half, 2 * half}},
            Solid{box_shape({0.5, 2 * half, 2 * half}, 0.1), {-0.25, 0, 0}},
            Mesh{{{0, -half, -half}, {0, half, -half}, {0, half, half}, {0, -half, half}}, {0, 1, 2, 0, 2, 3}}};
}

// What a paddle meets goes as fast as the paddle, or by twice its speed beside its own where it bounces. Solvers that push out what
// overlaps give it somewhat more.
TEST_F(MovingObstacles, APaddleGivesItsOwnSpeedOrTwiceIt) {
    for (const Settings& settings : all_engines({0, 0, 0}))
        for (const Shape& shape : walls())
            for (const float restitution : {0.0f, 1.0f})
                for (const bool cube : {false, true}) {
                    auto scene = make_scene(settings);
                    const auto material = need(scene->add_material({.friction = 0, .restitution = restitution}));
                    const auto wall = need(scene->add_obstacle(shape, material));
                    need(scene->move_obstacle(wall, steady(1.5)));
                    BodySpec spec{.id = 0, .position_m = {1.5, 0, 0}, .linear_velocity_m_s = {-0.5, 0, 0}, .material = material};
                    if (cube) spec.shape = box_shape({1, 1, 1}, 0.05);
                    need(scene->add_body(spec));
                    run(*scene, 240, 2, workers_);
                    // They meet after half a second.
                    const double wall_speed = speed_at(1.5, 0.5), expected = restitution == 0 ? wall_speed : 2 * wall_speed + 0.5;
                    const bool soft = settings.engine == EngineKind::Blocks && settings.solver.mode == SolverMode::Soft;
                    const double got = scene->state(0).linear_velocity_m_s.x;
                    EXPECT_TRUE(got > expected - 0.02 && got < expected + (soft || restitution > 0 ? 0.02 : 0.4))
                        << scene->obstacles().kind(wall) << " " << static_cast<int>(settings.engine) << " " << got << " not " << expected;
                }
}

// Nothing is behind a wall that comes through a step in half its diameter.
TEST_F(MovingObstacles, AFastWallPassesNothing) {
    for (const Shape& shape : walls(30))
        for (const double speed : {20.0, 120.0}) {
            auto scene = make_scene(settings_with({}));
            const auto wall = need(scene->add_obstacle(shape, 0));
            need(scene->move_obstacle(wall, steady(speed)));
            for (BodyId id = 0; id < 6; ++id) {
                BodySpec spec{.id = id, .position_m = {3 + 1.7 * id, 0.1 * id, 0.2}};
                if (id % 2 == 1) spec.shape = box_shape({1, 1, 1}, 0.05);
                need(scene->add_body(spec));
            }
            const int ticks = static_cast<int>(60 / speed / kTick);
            run(*scene, ticks, 2, workers_);
            const double face = 8 * speed * std::sin(ticks * kTick / 8);
            for (BodyId id = 0; id < 6; ++id)
                EXPECT_GT(scene->state(id).position_m.x, face + 0.4) << scene->obstacles().kind(wall) << " " << speed << " " << id;
        }
}

// The tip of a beam that turns at 60 m/s sweeps away what lies in its way, and nothing is left within its circle above the ground.
TEST_F(MovingObstacles, ATurningBeamSweepsItsCircle) {
    for (const bool mesh : {false, true}) {
        auto scene = scene_on_plane();
        const Mesh blade{{{-4, 0, 0}, {4, 0, 0}, {4, 0, 1}, {-4, 0, 1}}, {0, 1, 2, 0, 2, 3}};
        const auto beam = need(scene->add_obstacle(mesh ? Shape(blade) : Shape(Box{{0, 0, 0.5}, {8, 0.2, 1}}), 0));
        need(scene->move_obstacle(beam, {.spin_rad_s = {0, 0, 15}}));
        for (BodyId id = 0; id < 12; ++id) {
            const double angle = kTurn * (id + 0.5) / 12;
            BodySpec spec{.id = id, .position_m = {2.5 * std::cos(angle), 2.5 * std::sin(angle), 0.2}, .radius_m = 0.2};
            if (id % 2 == 1) spec.shape = box_shape({0.4, 0.4, 0.4}, 0.02);
            need(scene->add_body(spec));
        }
        run(*scene, 480, 2, workers_);
        for (BodyId id = 0; id < 12; ++id) {
            const Vec3 at = scene->state(id).position_m;
            EXPECT_GT(std::hypot(at.x, at.y), 4) << mesh << id;
        }
    }
}

// What lies on a turntable turns with it if friction holds it, connected or not, and slides off where it does not.
TEST_F(MovingObstacles, ATurntableTakesAlongWhatItCanHold) {
    for (const bool plane : {true, false})
        for (const double radius : {0.8, 2.0}) {
            auto scene = make_scene();
            const auto table = need(scene->add_obstacle(plane ? Shape(Plane{}) : Shape(Solid{cylinder_shape(4, 1, 0), {0, 0, -0.5}}), 0));
            // 0.5 g = w^2 r at 1.4 m.
            const double spin = std::sqrt(0.5 * kGravity / 1.4);
            need(scene->move_obstacle(table, {.spin_rad_s = {0, 0, spin}}));
            const auto add = [&](BodyId id, Vec3 at, bool cube) {
                BodySpec spec{.id = id, .position_m = at, .linear_velocity_m_s = spin * Vec3{-at.y, at.x, 0}, .radius_m = 0.1};
                spec.angular_velocity_rad_s = {0, 0, spin};
                if (cube) spec.shape = box_shape({0.2, 0.2, 0.2}, 0);
                need(scene->add_body(spec));
            };
            add(0, {radius, 0, 0.1}, true);
            add(1, {-radius - 0.1, 0, 0.1}, false), add(2, {-radius + 0.1, 0, 0.1}, false);
            need(scene->connect(1, 2));
            run(*scene, 240, 2, workers_);
            const auto away = [&](BodyId id) { return std::hypot(scene->state(id).position_m.x, scene->state(id).position_m.y); };
            for (const auto& [id, start] : {std::pair{BodyId{0}, radius}, std::pair{BodyId{1}, radius + 0.1}})
                EXPECT_TRUE(radius < 1 ? std::abs(away(id) - start) < 0.03 : away(id) > start + 0.5) << id << plane << " " << away(id);
        }
}

// A ball in the middle of a turntable turns with it by friction against spinning alone.
TEST_F(MovingObstacles, ATurntableTurnsABallInItsMiddle) {
    for (const Settings& settings : {all_engines()[0], all_engines()[1]}) {
        auto scene = make_scene(settings);
        const auto material = need(scene->add_material({.friction = 0.5f, .spinning_m = 0.05f}));
        const auto table = need(scene->add_obstacle(Plane{}, material));
        need(scene->move_obstacle(table, {.spin_rad_s = {0, 0, 2}}));
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .material = material}));
        run(*scene, 480, 2, workers_);
        EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, 2, 0.01);
    }
}

// Half the angular momentum of a spinning paddle's stroke: what it hits at rest, elastically, leaves with twice its speed there.
TEST_F(MovingObstacles, ABatHitsWithTwiceTheSpeedOfWhereItHits) {
    auto scene = make_scene(settings_with({}));
    const auto material = need(scene->add_material({.friction = 0, .restitution = 1}));
    const auto bat = need(scene->add_obstacle(Box{{2, 0, 0}, {4, 0.2, 1}}, material));
    need(scene->move_obstacle(bat, {.spin_rad_s = {0, 0, 2}, .pivot_m = Vec3{}}));
    need(scene->add_body({.id = 0, .position_m = {2, 2, 0}, .radius_m = 0.2, .material = material}));
    run(*scene, 120, 2, workers_);
    // It is hit about where it was, so by what is 2 sqrt(2) from the pivot, across the bat.
    EXPECT_NEAR(speed(*scene, 0), 2 * 2 * 2 * std::numbers::sqrt2, 0.15);
}

// The belt of a box turns with the box.
TEST_F(MovingObstacles, ABeltTurnsWithItsObstacle) {
    auto scene = make_scene();
    const auto table = need(scene->add_obstacle(Box{{0, 0, -0.5}, {4, 4, 1}}, 0));
    need(scene->set_belt(table, {0, 0.5, 0}));
    need(scene->move_obstacle(table, {.tilt_rad = {0, 0, kTurn / 4}, .frequency_hz = 0.125, .phase_rad = 0}));
    run(*scene, 480, 2, workers_);
    // A quarter turn after two seconds.
    const Vec3 now = scene->obstacles().velocity_at(table, {0, 0, 0}, {0, 0, 1});
    EXPECT_LT(length(now - Vec3{0, 0.5, 0}), 0.02);
}

// ---- sleep, and what sees them

TEST_F(MovingObstacles, WhatAPaddleWillMeetSleepsUntilItComes) {
    for (const bool cube : {false, true}) {
        auto scene = scene_on_plane();
        const auto paddle = need(scene->add_obstacle(Box{{-12, 0, 0.6}, {0.5, 3, 1}}, 0));
        need(scene->move_obstacle(paddle, {.swing_m = {5.6, 0, 0}, .frequency_hz = 0.1, .phase_rad = -kTurn / 4}));
        BodySpec spec{.id = 0, .position_m = {-2, 0, 0.5}};
        if (cube) spec.shape = box_shape({1, 1, 1}, 0.02);
        need(scene->add_body(spec));
        run(*scene, 480, 2, workers_);
        EXPECT_TRUE(scene->asleep(0));
        run(*scene, 720, 2, workers_);
        EXPECT_FALSE(scene->asleep(0));
        const double face = scene->obstacles().frame(paddle).centre_m().x + 0.25;
        EXPECT_NEAR(face, -12 + 2 * 5.6 + 0.25, 0.01);
        EXPECT_GT(scene->state(0).position_m.x, face + 0.49);
        EXPECT_GT(scene->state(0).position_m.x, -0.1);
    }
}

TEST_F(MovingObstacles, RaysMeetThemWhereTheyAre) {
    for (const Settings& settings : all_engines()) {
        auto scene = make_scene(settings);
        const auto box = need(scene->add_obstacle(Box{{4, 0, 0}, {2, 2, 2}}, 0));
        const auto plane = need(scene->add_obstacle(Plane{{0, 0, 1}, -3}, 0));
        const auto mesh = need(scene->add_obstacle(tube(1, 2, 40), 0));
        need(scene->move_obstacle(box, {.spin_rad_s = {0, 0, kTurn / 4}, .pivot_m = Vec3{}}));
        need(scene->move_obstacle(plane, {.swing_m = {0, 0, 1}, .frequency_hz = 0.25}));
        need(scene->move_obstacle(mesh, {.swing_m = {2, 0, 0}, .frequency_hz = 0.25}));
        need(scene->add_body({.id = 0, .position_m = {20, 20, 20}, .fixed = true}));
        run(*scene, 240, 2, workers_);
        const Obstacles& obstacles = scene->obstacles();
        EXPECT_FALSE(obstacles.first_on(box, {{0, 0, 0}, {10, 0, 0}}));
        EXPECT_NEAR(obstacles.first_on(box, {{0, 0, 0}, {0, 10, 0}}).value_or(-1), 0.3, 1e-9);
        EXPECT_NEAR(obstacles.first_on(plane, {{0, 0, 0}, {0, 0, -10}}).value_or(-1), 0.2, 1e-9);
        EXPECT_NEAR(obstacles.first_on(mesh, {{-5, 0, 0.01}, {10, 0, 0}}).value_or(-1), 0.6, 1e-3);
        EXPECT_NEAR(obstacles.depth(plane, {7, 7, -2}, 0.5), 0.5, 1e-9);
    }
}

TEST_F(MovingObstacles, WhatIsNotPossibleIsAnError) {
    auto scene = make_scene();
    EXPECT_EQ(scene->move_obstacle(0, {}).error().problem, "there is no obstacle 0");
    const auto floor = need(scene->add_obstacle(Plane{}, 0));
    EXPECT_FALSE(scene->move_obstacle(floor, {.frequency_hz = -1}));
    need(scene->move_obstacle(floor, {.swing_m = {0, 0, 2}, .frequency_hz = 0.5}));
    EXPECT_EQ(scene->move_obstacle(floor, {}).error().problem, "obstacle 0 moves already");
    auto hash = make_scene({.engine = EngineKind::Hash});
    const auto still = need(hash->add_obstacle(Plane{}, 0));
    EXPECT_EQ(hash->move_obstacle(still, {}).error().problem, "the engine Hash has no prescribed motions");

    // A body between what moves and what stands still.
    need(scene->add_obstacle(Plane{{0, 0, -1}, -1.1}, 0));
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}}));
    std::optional<Error> crushed;
    for (int tick = 0; tick < 240 && !crushed; ++tick)
        if (const auto done = scene->step(kTick, 2, workers_); !done) crushed = done.error();
    ASSERT_TRUE(crushed);
    EXPECT_NE(crushed->problem.find("deep in obstacle 0, a plane that moves"), std::string::npos) << crushed->problem;
    EXPECT_NE(crushed->suggestion.find("let the obstacle move more slowly"), std::string::npos);
}

// ---- the same bits

BodyShape dumbbell() { return compound_of({{.rounding_m = 0.25, .at_m = {0.2, 0, 0}}, {.rounding_m = 0.25, .at_m = {-0.2, 0, 0}}}).shape; }

// Balls, cubes and dumbbells that fall into a drum, on a swinging table and on tilting ground.
std::vector<BodySpec> bodies_among_obstacles() {
    std::vector<BodySpec> all;
    std::mt19937 random(12);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2), speed(-3, 3);
    for (BodyId id = 0; id < 360; ++id) {
        const double x = 1.3 * (id % 10) + jitter(random), y = 1.3 * (id / 10 % 6) + jitter(random);
        BodySpec& spec = all.emplace_back(
            BodySpec{.id = id, .position_m = {x, y, 2.2 + 1.3 * (id / 60)}, .radius_m = 0.4, .material = 1, .fixed = false});
        spec.linear_velocity_m_s = {speed(random), speed(random), 0};
        if (id % 3 == 0) spec.shape = box_shape({0.7, 0.7, 0.7}, 0.02);
        if (id % 3 == 1 && id % 2 == 0) spec.shape = dumbbell();
    }
    return all;
}
void furnish(Scene& scene, const std::function<bool(BodyId)>& mine) {
    const auto rough = need(scene.add_material({.friction = 0.6f, .restitution = 0.2f, .rolling_m = 0.02f, .spinning_m = 0.01f}));
    const auto move = [&](Shape shape, const PrescribedMotion& motion) {
        const auto obstacle = need(scene.add_obstacle(std::move(shape), rough));
        need(scene.move_obstacle(obstacle, motion));
        return obstacle;
    };
    need(scene.add_obstacle(Box{{0, 12, 0}, {3, 3, 3}}, 0));
    move(Plane{{0, 0, 1}, -2}, {.tilt_rad = {0.1, 0.05, 0}, .frequency_hz = 0.7, .pivot_m = Vec3{6, 4, -2}});
    need(scene.set_belt(move(Box{{3, 2, 0}, {4, 4, 1}}, {.swing_m = {0.3, 0, 0.2}, .frequency_hz = 3}), {0.3, 0.2, 0}));
    Mesh drum = tube(2, 4, 24);
    for (Vec3& point : drum.points) point = point + Vec3{9, 3, 0};
    move(drum, {.spin_rad_s = {0, 2, 0}});
    const BodyShape cross = compound_of({{.core_m = {2, 0.1, 0.1}, .rounding_m = 0.1}, {.core_m = {0.1, 2, 0.1}, .rounding_m = 0.1}}).shape;
    move(Solid{cross, {5, 5, 1}}, {.spin_rad_s = {0, 0, 4}});
    move(Terrain{{-8, -8, -1.5}, 2, 6, 6, std::vector<double>(36, 0.5)}, {.swing_m = {0, 0, 0.1}, .frequency_hz = 5});
    for (const BodySpec& spec : bodies_among_obstacles())
        if (mine(spec.id)) need(scene.add_body(spec));
}

TEST_F(MovingObstacles, PartsAndWorkersGiveTheSameBits) {
    auto whole = make_scene(settings_for_shapes());
    furnish(*whole, [](BodyId) { return true; });
    Workers two(2);
    auto again = make_scene(settings_for_shapes());
    furnish(*again, [](BodyId) { return true; });
    Divided parts(3, [](BlockCoordinates b) { return ((b.x + b.y) % 3 + 3) % 3; }, furnish, settings_for_shapes());
    for (int tick = 0; tick < 150; ++tick) {
        run(*whole, 1, 2, workers_);
        run(*again, 1, 2, two);
        parts.tick();
        ASSERT_EQ(again->digest(), whole->digest()) << tick;
        ASSERT_EQ(parts.digest(), whole->digest()) << tick;
    }
}

TEST_F(MovingObstacles, SnapshotsGoOnWithTheSameBits) {
    const auto empty = [] {
        auto scene = make_scene(settings_for_shapes());
        furnish(*scene, [](BodyId) { return false; });
        return scene;
    };
    expect_same_bits(empty, [](Scene& scene) {
        for (const BodySpec& spec : bodies_among_obstacles()) need(scene.add_body(spec));
    });
}

}  // namespace
}  // namespace meld::physics::moving
