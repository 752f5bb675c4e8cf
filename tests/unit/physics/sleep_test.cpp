// What must not fall asleep, against formulas, and what must.
#include <gtest/gtest.h>

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
