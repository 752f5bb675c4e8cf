// Fixed bodies that move as is prescribed, belts, and gravity that changes, against mechanics; and the same bits in parts and through
// snapshots.
#include "physics/bodies/prescribed_motion.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/physics/divided_world.h"
#include "tests/unit/physics/scenes.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

void prescribe(Scene& scene, BodyId body, const PrescribedMotion& motion) {
    const auto number = need(scene.add_motion(motion));
    const BodyState state = scene.state(body);
    need(scene.prescribe(body, number, {state.position_m, state.orientation}));
}

Settings with_pgs() {
    Settings settings;
    settings.solver = SolverSettings::pgs20();
    return settings;
}

class Prescribed : public testing::Test {
  protected:
    Workers workers_{1};
};

TEST_F(Prescribed, FollowsTheSineWhereverItIs) {
    for (const EngineKind engine : {EngineKind::Blocks, EngineKind::Ode}) {
        auto scene = make_scene({.engine = engine});
        need(scene->add_body({.id = 0, .position_m = {5, 0, 1}, .fixed = true}));
        prescribe(*scene, 0, {.swing_m = {0, 0, 0.2}, .frequency_hz = 3, .phase_rad = kTurn / 4});
        for (int tick = 1; tick <= 100; ++tick) {
            run(*scene, 1, 2, workers_);
            const double expected = 0.2 * (std::cos(kTurn * 3 * tick * kTick) - 1);
            ASSERT_NEAR(scene->state(0).position_m.z, 1 + expected, 1e-9) << tick;
        }
    }
}

TEST_F(Prescribed, TurnsAboutAPivotAndTiltsBeforeThat) {
    auto scene = make_scene();
    need(scene->add_body({.id = 0, .position_m = {2, 0, 0}, .fixed = true}));
    prescribe(*scene, 0, {.spin_rad_s = {0, 0, kTurn / 4}, .pivot_m = Vec3{1, 0, 0}});
    run(*scene, 240, 2, workers_);
    EXPECT_LT(length(scene->state(0).position_m - Vec3{1, 1, 0}), 1e-9);
    EXPECT_LT(length(rotate(scene->state(0).orientation, {1, 0, 0}) - Vec3{0, 1, 0}), 1e-6);
    EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, kTurn / 4, 1e-4);
    EXPECT_LT(length(scene->state(0).linear_velocity_m_s - kTurn / 4 * Vec3{-1, 0, 0}), 0.01);

    const PrescribedMotion tilting{.tilt_rad = {0.3, 0, 0}, .frequency_hz = 1, .spin_rad_s = {0, 0, 1}};
    const PrescribedMotion::Place at = tilting.at({{1, 2, 3}, {}}, 0.25);
    EXPECT_EQ(at.centre_m, (Vec3{1, 2, 3}));
    const Vec3 up = rotate(at.turn, {0, 0, 1});
    EXPECT_NEAR(up.z, std::cos(0.3), 1e-12);
    EXPECT_NEAR(std::atan2(up.x, -up.y), 0.25, 1e-9);
}

// A belt takes a block along by mu g until it has the belt's speed, and goes on below it.
TEST_F(Prescribed, ABlockReachesTheSpeedOfTheBeltAfterTheTimeOfFriction) {
    const double time = 0.8 / (0.2 * kGravity);
    for (const Settings& settings : {Settings{}, with_pgs(), Settings{.engine = EngineKind::Ode}})
        for (const bool plane : {true, false}) {
            auto scene = make_scene(settings);
            const auto material = need(scene->add_material({.friction = 0.2f}));
            const auto obstacle =
                plane ? need(scene->add_obstacle(Plane{}, material)) : need(scene->add_obstacle(Box{{0, 0, -0.5}, {20, 2, 1}}, material));
            need(scene->set_belt(obstacle, {0, 0.8, 0}));
            need(scene->add_body({.id = 0, .position_m = {-1, 0, 0.25}, .material = material, .shape = box_shape({0.5, 0.5, 0.5}, 0.01)}));
            // Two balls, connected: they cannot roll.
            if (settings.engine == EngineKind::Blocks) {
                for (const BodyId id : {1u, 2u}) need(scene->add_body({.id = id, .position_m = {1.0 * id, 0, 0.5}, .material = material}));
                need(scene->connect(1, 2));
            }
            run(*scene, static_cast<int>(0.5 * time / kTick), 2, workers_);
            for (const BodyId id : scene->bodies())
                EXPECT_NEAR(scene->state(id).linear_velocity_m_s.x, 0.4, 0.03) << static_cast<int>(settings.engine) << plane << id;
            run(*scene, static_cast<int>(0.7 * time / kTick), 2, workers_);
            for (const BodyId id : scene->bodies())
                EXPECT_NEAR(scene->state(id).linear_velocity_m_s.x, 0.8, 0.005) << static_cast<int>(settings.engine) << plane << id;
        }
}

// Its ends take along downwards, and its sides not at all; nothing is pushed away.
TEST_F(Prescribed, ABeltRunsRoundItsObstacle) {
    const auto against = [&](Vec3 normal) {
        auto scene = make_scene(settings_with(-kGravity * normal));
        const auto obstacle = need(scene->add_obstacle(Box{{0, 0, 0}, {4, 4, 4}}, 0));
        need(scene->set_belt(obstacle, {0, 0.5, 0}));
        need(scene->add_body({.id = 0, .position_m = 2.25 * normal, .shape = box_shape({0.5, 0.5, 0.5}, 0.01)}));
        run(*scene, 120, 2, workers_);
        return scene->state(0).linear_velocity_m_s;
    };
    EXPECT_LT(length(against({0, 0, 1}) - Vec3{0.5, 0, 0}), 0.01);
    EXPECT_LT(length(against({1, 0, 0}) - Vec3{0, 0, -0.5}), 0.01);
    EXPECT_LT(length(against({0, 0, -1}) - Vec3{-0.5, 0, 0}), 0.01);
    EXPECT_LT(length(against({0, 1, 0})), 0.01);
}

// A ball on a belt rolls: it gets 2/7 of its speed, and turns the other way.
TEST_F(Prescribed, ABallOnABeltRolls) {
    for (const Settings& settings : {Settings{}, with_pgs(), Settings{.engine = EngineKind::Ode}}) {
        auto scene = make_scene(settings);
        const auto obstacle = need(scene->add_obstacle(Plane{}, 0));
        need(scene->set_belt(obstacle, {0, 1.4, 0}));
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}}));
        run(*scene, 240, 2, workers_);
        EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 0.4, 0.005);
        EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.y, -2, 0.02);
    }
}

// A block that a wall holds on a belt slips, and stays awake as what lies on level ground does not.
TEST_F(Prescribed, WhatIsOnABeltStaysAwake) {
    for (const double speed : {0.0, 0.5}) {
        auto scene = make_scene();
        const auto ground = need(scene->add_obstacle(Plane{}, 0));
        need(scene->set_belt(ground, {0, speed, 0}));
        need(scene->add_obstacle(Plane{{-1, 0, 0}, -1}, 0));
        need(scene->add_body({.id = 0, .position_m = {0.75, 0, 0.25}, .shape = box_shape({0.5, 0.5, 0.5}, 0.01)}));
        run(*scene, 480, 2, workers_);
        EXPECT_EQ(scene->asleep(0), speed == 0);
        EXPECT_NEAR(scene->state(0).position_m.x, 0.75, 0.01);
    }
}

// A body on a plate that shakes up and down stays on it below g and leaves it above. It is never asleep on it.
TEST_F(Prescribed, ABodyLeavesAShakerAboveG) {
    for (const double share : {0.8, 2.0}) {
        auto scene = make_scene();
        need(scene->add_body({.id = 1, .position_m = {0, 0, -0.5}, .fixed = true, .shape = box_shape({2, 2, 1}, 0.02)}));
        const double frequency = 2, amplitude = share * kGravity / (kTurn * frequency * kTurn * frequency);
        prescribe(*scene, 1, {.swing_m = {0, 0, amplitude}, .frequency_hz = frequency});
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .shape = box_shape({1, 1, 1}, 0.02)}));
        double farthest = 0;
        for (int tick = 0; tick < 480; ++tick) {
            run(*scene, 1, 2, workers_);
            farthest = std::max(farthest, scene->state(0).position_m.z - scene->state(1).position_m.z - 1);
            EXPECT_FALSE(scene->asleep(0));
        }
        if (share < 1)
            EXPECT_LT(farthest, 5e-3);
        else
            EXPECT_GT(farthest, 0.1);
    }
}

// What lies on a turntable turns with it if friction holds it, and slides off where it does not.
TEST_F(Prescribed, ATurntableTakesAlongWhatItCanHold) {
    for (const double radius : {0.5, 1.5}) {
        auto scene = make_scene();
        need(scene->add_body({.id = 1, .position_m = {0, 0, -0.25}, .fixed = true, .shape = cylinder_shape(2.5, 0.5, 0)}));
        // 0.5 g = w^2 r at 1.09 m.
        prescribe(*scene, 1, {.spin_rad_s = {0, 0, std::sqrt(0.5 * kGravity / 1.09)}});
        const double speed = std::sqrt(0.5 * kGravity / 1.09) * radius;
        need(scene->add_body({.id = 0,
                              .position_m = {radius, 0, 0.1},
                              .linear_velocity_m_s = {0, speed, 0},
                              .angular_velocity_rad_s = {0, 0, speed / radius},
                              .shape = box_shape({0.2, 0.2, 0.2}, 0)}));
        run(*scene, 240, 2, workers_);
        const Vec3 at = scene->state(0).position_m;
        const double now = std::hypot(at.x, at.y);
        if (radius < 1)
            EXPECT_NEAR(now, radius, 0.03);
        else
            EXPECT_GT(now, radius + 0.5);
    }
}

// A block on a tilting table slides as soon as the slope is steeper than friction holds: 16.7 degrees.
TEST_F(Prescribed, ABlockSlidesOnATiltingTable) {
    for (const Settings& settings : {Settings{}, with_pgs(), Settings{.engine = EngineKind::Ode}}) {
        auto scene = make_scene(settings);
        const auto material = need(scene->add_material({.friction = 0.3f}));
        need(scene->add_body({.id = 1, .position_m = {0, 0, -0.5}, .material = material, .fixed = true, .shape = box_shape({4, 4, 1}, 0)}));
        prescribe(*scene, 1, {.tilt_rad = {0, kTurn / 12, 0}, .frequency_hz = 0.1});
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.25}, .material = material, .shape = box_shape({0.5, 0.5, 0.5}, 0)}));
        const auto time_of = [](double degrees) { return std::asin(degrees / 30) / (kTurn * 0.1); };
        const auto along = [&] {
            return rotate(conjugate(scene->state(1).orientation), scene->state(0).position_m - scene->state(1).position_m).x;
        };
        run(*scene, static_cast<int>(time_of(16) / kTick), 2, workers_);
        EXPECT_NEAR(along(), 0, 0.02) << static_cast<int>(settings.engine);
        run(*scene, static_cast<int>((time_of(22) - time_of(16)) / kTick), 2, workers_);
        // Its acceleration has grown from 0 to 0.95 m/s^2 within 0.37 s.
        EXPECT_NEAR(along(), 0.022, 0.006) << static_cast<int>(settings.engine);
    }
}

// What is connected to it moves along.
TEST_F(Prescribed, CarriesWhatIsConnected) {
    auto scene = make_scene();
    for (const BodyId id : {0u, 1u}) need(scene->add_body({.id = id, .position_m = {1.0 * id, 0, 0}, .fixed = id == 0}));
    need(scene->connect(0, 1));
    prescribe(*scene, 0, {.swing_m = {0, 0, 0.5}, .frequency_hz = 1, .spin_rad_s = {0, 0, kTurn / 4}});
    run(*scene, 240, 2, workers_);
    EXPECT_LT(length(scene->state(1).position_m - Vec3{0, 1, 0}), 1e-6);
    run(*scene, 60, 2, workers_);
    EXPECT_NEAR(scene->state(1).position_m.z, 0.5, 1e-6);
}

// Also where the body is turned when it is connected.
TEST_F(Prescribed, CarriesWhatIsConnectedToATurnedBody) {
    auto scene = make_scene();
    need(scene->add_body({.id = 0, .orientation = turn_of(1, {1, 2, 3}), .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {1, 0, 0}, .orientation = turn_of(2, {0, 1, 1})}));
    need(scene->connect(0, 1));
    prescribe(*scene, 0, {.spin_rad_s = {0, 0, kTurn / 4}});
    run(*scene, 240, 2, workers_);
    EXPECT_LT(length(scene->state(1).position_m - Vec3{0, 1, 0}), 1e-6);
    const Vec3 own{1, 0, 0}, quarter = rotate(turn_of(kTurn / 4, {0, 0, 1}), rotate(turn_of(2, {0, 1, 1}), own));
    EXPECT_LT(length(rotate(scene->state(1).orientation, own) - quarter), 1e-5);
    EXPECT_LT(length(scene->state(1).linear_velocity_m_s - kTurn / 4 * Vec3{-1, 0, 0}), 0.01);
}

TEST_F(Prescribed, WhatIsNotPossibleIsAnError) {
    auto scene = make_scene();
    need(scene->add_body({.id = 0}));
    EXPECT_FALSE(scene->add_motion({.frequency_hz = -1}));
    EXPECT_EQ(scene->prescribe(0, 0, {}).error().problem, "there is no motion 0");
    const auto motion = need(scene->add_motion({.swing_m = {1, 0, 0}, .frequency_hz = 1}));
    EXPECT_EQ(scene->prescribe(0, motion, {}).error().problem, "body 0 has a prescribed motion, but is not fixed");
    EXPECT_FALSE(make_scene({.engine = EngineKind::Hash})->add_motion({}));
    EXPECT_FALSE(scene->set_belt(0, {1, 0, 0}));
    need(scene->add_obstacle(Plane{}, 0));
    need(scene->set_belt(0, {1, 0, 0}));
    EXPECT_FALSE(scene->set_belt(0, {2, 0, 0}));
    EXPECT_FALSE(scene->set_gravity({std::numeric_limits<double>::infinity(), 0, 0}));
}

// ---- gravity

TEST_F(Prescribed, GravityThatChangesWakesWhatSlept) {
    for (const EngineKind engine : {EngineKind::Blocks, EngineKind::Hash, EngineKind::Ode}) {
        auto scene = scene_on_plane({.engine = engine});
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}}));
        run(*scene, 240, 2, workers_);
        EXPECT_EQ(scene->asleep(0), engine == EngineKind::Blocks);
        need(scene->set_gravity({0, 0, 2}));
        EXPECT_EQ(scene->gravity_m_s2(), (Vec3{0, 0, 2}));
        run(*scene, 120, 2, workers_);
        EXPECT_NEAR(scene->state(0).linear_velocity_m_s.z, 1, 0.02);
        EXPECT_NEAR(scene->state(0).position_m.z, 0.75, 0.02);
    }
}

// ---- the same bits

// Shakers, a turntable and belts, the first hundred, and balls and cubes above them.
std::vector<BodySpec> bodies_on_movers() {
    std::vector<BodySpec> all;
    std::mt19937 random(8);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2), speed(-3, 3);
    for (BodyId id = 0; id < 500; ++id) {
        const bool fixed = id < 100;
        const auto away = [&] { return fixed ? 0 : jitter(random); };
        const double x = 1.3 * (id % 10) + away(), y = 1.3 * (id / 10 % 10) + away();
        BodySpec& spec = all.emplace_back(BodySpec{
            .id = id, .position_m = {x, y, (fixed ? 0.5 : 1.2) + 1.3 * (id / 100)}, .radius_m = 0.4, .material = 1, .fixed = fixed});
        if (!fixed) spec.linear_velocity_m_s = {speed(random), speed(random), 0};
        if (id % 2 == 0) spec.shape = box_shape({0.7, 0.7, 0.7}, 0.02);
    }
    return all;
}
// With those of the bodies for which the function says so.
void furnish_movers(Scene& scene, const std::function<bool(BodyId)>& mine) {
    const auto rough = need(scene.add_material({.friction = 0.6f, .restitution = 0.2f, .rolling_m = 0.02f, .spinning_m = 0.01f}));
    const auto ground = need(scene.add_obstacle(Plane{}, rough));
    need(scene.set_belt(ground, {-0.2, 0.5, 0}));
    const auto box = need(scene.add_obstacle(Box{.centre = {6, 6, 1}, .size_m = {3, 2, 2}}, 0));
    need(scene.set_belt(box, {-1, 0, 0}));
    std::vector<std::uint32_t> motions;
    for (const PrescribedMotion& motion :
         {PrescribedMotion{.swing_m = {0, 0, 0.2}, .frequency_hz = 3}, PrescribedMotion{.spin_rad_s = {0, 0, 2}},
          PrescribedMotion{.tilt_rad = {0.2, 0, 0}, .frequency_hz = 1}})
        motions.push_back(need(scene.add_motion(motion)));
    for (const BodySpec& spec : bodies_on_movers()) {
        if (spec.fixed) need(scene.prescribe(spec.id, motions[spec.id % 3], {spec.position_m, spec.orientation}));
        if (mine(spec.id)) need(scene.add_body(spec));
    }
}

TEST_F(Prescribed, PartsAndWorkersGiveTheSameBits) {
    auto whole = make_scene(settings_for_shapes());
    furnish_movers(*whole, [](BodyId) { return true; });
    Workers two(2);
    auto again = make_scene(settings_for_shapes());
    furnish_movers(*again, [](BodyId) { return true; });
    Divided parts(3, [](BlockCoordinates b) { return ((b.x + b.y) % 3 + 3) % 3; }, furnish_movers, settings_for_shapes());
    for (int tick = 0; tick < 60; ++tick) {
        run(*whole, 1, 2, workers_);
        run(*again, 1, 2, two);
        parts.tick();
        ASSERT_EQ(again->digest(), whole->digest()) << tick;
        ASSERT_EQ(parts.digest(), whole->digest()) << tick;
    }
}

TEST_F(Prescribed, SnapshotsGoOnWithTheSameBits) {
    const auto empty = [] {
        auto scene = make_scene(settings_for_shapes());
        furnish_movers(*scene, [](BodyId) { return false; });
        return scene;
    };
    expect_same_bits(empty, [](Scene& scene) {
        for (const BodySpec& spec : bodies_on_movers()) need(scene.add_body(spec));
    });
}

}  // namespace
}  // namespace meld::physics
