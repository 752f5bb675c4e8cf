// What must not fall asleep, against formulas, and what must.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

class FallingAsleep : public testing::Test {
  protected:
    void step(Scene& scene, int ticks, double dt_s) {
        for (int tick = 0; tick < ticks; ++tick) {
            const auto report = scene.step(dt_s, 2, workers_);
            ASSERT_TRUE(report) << report.error().message();
        }
    }
    Workers workers_{1};
};

TEST_F(FallingAsleep, WeakGravityLetsFall) {
    auto scene = make_scene({.gravity_m_s2 = {0, 0, -0.03}});
    need(scene->add_body({.id = 0, .position_m = {0, 0, 5}}));
    step(*scene, 960, kTick);
    EXPECT_NEAR(scene->state(0).position_m.z, 5 - 0.03 * 16 / 2, 1e-3);
}

TEST_F(FallingAsleep, ShortStepsLetFall) {
    auto scene = make_scene();
    need(scene->add_body({.id = 0, .position_m = {0, 0, 5}}));
    step(*scene, 1000, 1e-5);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.z, -9.81 * 0.01, 1e-5);
}

TEST_F(FallingAsleep, SlowFixedBodiesGoOnAndCarry) {
    auto scene = make_scene();
    need(scene->add_body({.id = 0, .linear_velocity_m_s = {0.003, 0, 0}, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {5, 0, 0}, .angular_velocity_rad_s = {0, 0, 0.001}, .fixed = true}));
    step(*scene, 960, kTick);
    EXPECT_NEAR(scene->state(0).position_m.x, 0.012, 1e-6);
    EXPECT_NEAR(scene->state(1).orientation.z, std::sin(0.002), 1e-5);
}

TEST_F(FallingAsleep, ASlowHeavyPairKeepsItsMomentum) {
    auto scene = make_scene({.gravity_m_s2 = {}});
    need(scene->add_body({.id = 0, .linear_velocity_m_s = {0.004, 0, 0}, .mass_kg = 1000}));
    need(scene->add_body({.id = 1, .position_m = {1.005, 0, 0}, .mass_kg = 1000}));
    const Vec3 momentum = scene->momentum();
    step(*scene, 960, kTick);
    EXPECT_NEAR(scene->momentum().x, momentum.x, 1e-4 * momentum.x);
    EXPECT_GT(scene->state(1).position_m.x, 1.006);
}

// Rolling without slipping takes 5/7 of the pull along the ground, here of a slope of a tenth of a degree and of a gentle force.
TEST_F(FallingAsleep, WhatBeginsToRollGoesOn) {
    const double slope = 0.002;
    auto tilted = scene_on_plane({.gravity_m_s2 = {9.81 * slope, 0, -9.81}});
    need(tilted->add_body({.id = 0, .position_m = {0, 0, 0.5}}));
    auto pulled = scene_on_plane();
    need(pulled->add_body({.id = 0, .position_m = {0, 0, 0.5}}));
    need(pulled->set_wrench(0, {9.81 * slope, 0, 0}, {}));
    for (Scene* scene : {tilted.get(), pulled.get()}) {
        step(*scene, 960, kTick);
        const double way = 5.0 / 7 * 9.81 * slope * 16 / 2;
        EXPECT_NEAR(scene->state(0).position_m.x, way, 0.02 * way);
    }
}

// At the end of its way up a gentle slope a ball is slow for long, and then comes back as fast as it went.
TEST_F(FallingAsleep, WhatTurnsRoundComesBack) {
    for (const double slope : {0.001, 0.002, 0.006, 0.02}) {
        const double speed = 0.03, time = 2 * speed / (5.0 / 7 * 9.81 * slope);
        auto scene = scene_on_plane({.gravity_m_s2 = {-9.81 * slope, 0, -9.81}});
        need(scene->add_body(
            {.id = 0, .position_m = {0, 0, 0.5}, .linear_velocity_m_s = {speed, 0, 0}, .angular_velocity_rad_s = {0, 2 * speed, 0}}));
        step(*scene, static_cast<int>(time / kTick), kTick);
        EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, -speed, 0.02 * speed) << slope;
        EXPECT_NEAR(scene->state(0).position_m.x, 0, 0.02 * speed * time) << slope;
    }
}

// The same while lists are made often, for a body far away that is fast, and those of the pile and of a ball that turns where it lies are
// in its block.
TEST_F(FallingAsleep, WhatTurnsRoundAmongOthersComesBack) {
    const double slope = 0.002, speed = 0.03, time = 2 * speed / (5.0 / 7 * 9.81 * slope);
    for (const double fast : {0.0, 2.0, 30.0}) {
        auto scene = make_scene({.gravity_m_s2 = {-9.81 * slope, 0, -9.81}});
        need(scene->add_obstacle(Plane{}, 0));
        need(scene->add_obstacle(Plane{{1, 0, 0}, -0.5}, 0));
        add_cube(*scene, 3);
        need(scene->add_body(
            {.id = 64, .position_m = {5, 1, 0.5}, .linear_velocity_m_s = {speed, 0, 0}, .angular_velocity_rad_s = {0, 2 * speed, 0}}));
        need(scene->add_body({.id = 65, .position_m = {0, 4, 0.5}, .angular_velocity_rad_s = {0, 0, 0.007}}));
        need(scene->add_body({.id = 66, .position_m = {0, 500, 5}, .linear_velocity_m_s = {fast, 0, 0}, .fixed = true}));
        step(*scene, static_cast<int>(time / kTick), kTick);
        EXPECT_NEAR(scene->state(64).linear_velocity_m_s.x, -speed, 0.02 * speed) << fast;
    }
}

// A ball that swings in a wide hollow is slow at both ends, and goes on as the formula for small swings says.
TEST_F(FallingAsleep, SwingsInAHollowGoOn) {
    const double bend = 40, width = 0.1, period = 2 * std::numbers::pi * std::sqrt(1.4 * (bend - 0.5) / 9.81);
    Terrain hollow{.origin = {-4, -4, 0}, .cell_m = 0.02, .columns = 401, .rows = 401};
    for (int row = 0; row < 401; ++row)
        for (int column = 0; column < 401; ++column) {
            const double x = 0.02 * column - 4, y = 0.02 * row - 4;
            hollow.heights_m.push_back((x * x + y * y) / (2 * bend));
        }
    auto scene = make_scene();
    need(scene->add_obstacle(hollow, 0));
    need(scene->add_body({.id = 0, .position_m = {width, 0, 0.5 + width * width / (2 * bend)}}));
    std::vector<double> turns;
    double before = 0;
    for (int tick = 0; tick < static_cast<int>(2.1 * period / kTick); ++tick) {
        step(*scene, 1, kTick);
        const double now = scene->state(0).linear_velocity_m_s.x;
        if (before * now < 0) turns.push_back(tick * kTick);
        before = now;
    }
    ASSERT_GE(turns.size(), 4u);
    EXPECT_NEAR(turns[3], 2 * period, 0.1 * period);
}

// In a fluid so thick that it falls hardly faster than what counts as still, a body falls.
TEST_F(FallingAsleep, WhatSinksSlowlyGoesOn) {
    for (const double damping : {500.0, 4000.0, 1e6}) {
        auto scene = make_scene({.linear_damping_per_s = damping});
        need(scene->add_body({.id = 0, .position_m = {0, 0, 5}}));
        step(*scene, 960, kTick);
        const double way = 4 * 9.81 / damping;
        EXPECT_NEAR(5 - scene->state(0).position_m.z, way, 0.02 * way) << damping;
    }
}

TEST_F(FallingAsleep, GentleMagnetsDrawTogether) {
    auto scene = scene_on_plane();
    std::vector<Feature> features;
    for (const Vec3 direction : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}})
        features.push_back({.direction = direction, .strength = 7, .depth_m = 0.05, .range_m = 0.5});
    const auto table = need(scene->add_feature_table(features));
    for (BodyId id = 0; id < 2; ++id) {
        need(scene->add_body({.id = id, .position_m = {1.2 * id, 0, 0.5}}));
        need(scene->set_feature_table(id, table));
        need(scene->set_features(id, 3, 2));
    }
    step(*scene, 2400, kTick);
    EXPECT_LT(scene->state(1).position_m.x - scene->state(0).position_m.x, 1.01);
}

// On ice, held in the field of a fixed magnet above it, a ball swings for ever, by a few thousandths of its diameter. It is one of many
// in its block.
TEST_F(FallingAsleep, PilesFallAsleepAroundARattler) {
    auto scene = scene_on_plane();
    add_cube(*scene, 4);
    const std::uint8_t ice = need(scene->add_material({.friction = 0}));
    const auto table = need(scene->add_feature_table(
        {{.direction = {0, 0, 1}, .strength = 50, .range_m = 0.5}, {.direction = {0, 0, -1}, .strength = 50, .range_m = 0.5}}));
    need(scene->add_body({.id = 64, .position_m = {6, 1.5, 1.6}, .material = ice, .fixed = true}));
    need(scene->add_body({.id = 65, .position_m = {6.004, 1.5, 0.5}, .material = ice}));
    for (const BodyId id : {64u, 65u}) need(scene->set_feature_table(id, table));
    need(scene->set_features(64, 2, 0));
    need(scene->set_features(65, 1, 1));
    // It swings faster than what counts as still, as long as it is looked at, ...
    double least = 6.004, most = 6.004, fastest = 0;
    for (int tick = 0; tick < 720; ++tick) {
        step(*scene, 1, kTick);
        least = std::min(least, scene->state(65).position_m.x), most = std::max(most, scene->state(65).position_m.x);
        const BodyState now = scene->state(65);
        fastest = std::max(fastest, std::hypot(length(now.linear_velocity_m_s), 0.5 * length(now.angular_velocity_rad_s)));
    }
    EXPECT_LT(least, 5.999);
    EXPECT_GT(fastest, 0.006);
    EXPECT_LT(most, 6.008);
    // ... and after a few swings all sleep.
    step(*scene, 2400, kTick);
    for (BodyId id = 0; id < 64; ++id) EXPECT_TRUE(scene->asleep(id)) << id;
}

// What rolls away is no rattler, however slowly, and is not stopped.
TEST_F(FallingAsleep, ASlowBallRollsPastAPile) {
    auto scene = scene_on_plane();
    add_cube(*scene, 4);
    need(scene->add_body(
        {.id = 64, .position_m = {5, 1.5, 0.5}, .linear_velocity_m_s = {0.01, 0, 0}, .angular_velocity_rad_s = {0, 0.02, 0}}));
    step(*scene, 2400, kTick);
    EXPECT_NEAR(scene->state(64).position_m.x, 5.1, 0.002);
}

TEST_F(FallingAsleep, PilesOfAnySizeFallAsleep) {
    for (const double size : {1.0, 0.01}) {
        auto scene = scene_on_plane({.linear_damping_per_s = 2, .angular_damping_per_s = 2});
        for (BodyId id = 0; id < 64; ++id)
            need(scene->add_body({.id = id,
                                  .position_m = size * Vec3{1.0 * (id % 4), 1.0 * (id / 4 % 4), 0.5 + (id / 16)},
                                  .radius_m = size / 2,
                                  .mass_kg = size * size * size}));
        step(*scene, 1200, kTick * std::sqrt(size));
        for (BodyId id = 0; id < 64; ++id) EXPECT_TRUE(scene->asleep(id)) << size << " m, body " << id;
    }
}

// A high touching stack settles for a while, and sleeps before it topples.
TEST_F(FallingAsleep, HighStacksSleepBeforeTheyTopple) {
    auto scene = scene_on_plane();
    add_cube(*scene, 22);
    step(*scene, 150, kTick);
    EXPECT_EQ(scene->awake_bodies(), 0u);
    EXPECT_NEAR(scene->state(22 * 22 * 22 - 1).position_m.z, 21.5, 0.01);
}

// A body that was added after the last step is in no block yet: it is awake, and what happens to it wakes no other.
TEST_F(FallingAsleep, NewBodiesAreAwakeAndAlone) {
    auto scene = scene_on_plane({.sleep_ticks = 5});
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}}));
    step(*scene, 60, kTick);
    ASSERT_TRUE(scene->asleep(0));
    need(scene->add_body({.id = 1, .position_m = {100, 0, 0.5}}));
    EXPECT_FALSE(scene->asleep(1));
    need(scene->set_wrench(1, {1, 0, 0}, {}));
    step(*scene, 1, kTick);
    EXPECT_TRUE(scene->asleep(0));
    EXPECT_FALSE(scene->asleep(1));
}

// A list that is made while a pile sleeps knows its contacts, so that the pile does not fall for a moment when it wakes.
TEST_F(FallingAsleep, PilesWakeOnTheirContacts) {
    auto scene = scene_on_plane();
    add_cube(*scene, 3);
    step(*scene, 480, kTick);
    ASSERT_TRUE(scene->asleep(0));
    need(scene->add_body({.id = 27, .position_m = {100, 0, 50}}));
    step(*scene, 1, kTick);
    ASSERT_TRUE(scene->asleep(0));
    ASSERT_FALSE(scene->contacts().empty());
    for (const ContactReport& contact : scene->contacts()) {
        EXPECT_NEAR(length(contact.normal), 1, 1e-6);
        EXPECT_LT(std::abs(contact.gap_m), 0.01);
    }
    need(scene->set_wrench(26, {}, {}));
    step(*scene, 1, kTick);
    ASSERT_FALSE(scene->asleep(0));
    for (BodyId id = 0; id < 27; ++id) EXPECT_LT(length(scene->state(id).linear_velocity_m_s), 1e-4) << id;
}

}  // namespace
}  // namespace meld::physics
