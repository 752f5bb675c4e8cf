// What a scene tells: touch events, contacts by body, pressure, sleep.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

class Sensing : public testing::TestWithParam<EngineKind> {
  protected:
    Settings settings() const { return {.engine = GetParam()}; }
    Workers workers_{1};
};

TEST_P(Sensing, TouchBeginsAndEndsOnce) {
    Settings some = settings();
    some.gravity_m_s2 = {};
    auto scene = make_scene(some);
    const auto material = need(scene->add_material({.friction = 0.0f, .restitution = 1.0f}));
    need(scene->add_body({.id = 9, .position_m = {-1.5, 0, 0}, .linear_velocity_m_s = {2, 0, 0}, .material = material}));
    need(scene->add_body({.id = 4, .position_m = {0, 0, 0}, .material = material}));
    std::vector<TouchEvent> events;
    for (int tick = 0; tick < 240; ++tick) {
        run(*scene, 1, 1, workers_);
        events.insert(events.end(), scene->events().begin(), scene->events().end());
    }
    const Touch touch{4, 9, false};
    ASSERT_EQ(events.size(), 2u);
    EXPECT_EQ(events[0], (TouchEvent{touch, true}));
    EXPECT_EQ(events[1], (TouchEvent{touch, false}));
    EXPECT_TRUE(scene->contacts().empty());
}

TEST_P(Sensing, RestingBallPressesWithItsWeight) {
    Settings some = settings();
    some.solver = GetParam() == EngineKind::Blocks ? SolverSettings{} : SolverSettings::pgs20();
    some.sleep_ticks = 0;
    auto scene = scene_on_plane(some);
    need(scene->add_body({.id = 5, .position_m = {0, 0, 0.499}, .mass_kg = 3}));
    run(*scene, 480, 1, workers_);
    ASSERT_EQ(scene->contacts().size(), 1u);
    const ContactReport& contact = scene->contacts()[0];
    EXPECT_EQ(contact.touch, (Touch{5, 0, true}));
    EXPECT_NEAR(contact.normal.z, -1, 1e-6);
    EXPECT_NEAR(contact.normal_force_n, 3 * 9.81, 0.3);
    EXPECT_NEAR(scene->pressure(5), contact.normal_force_n / (std::numbers::pi), 1e-9);
}

TEST_P(Sensing, ContactsOfABodyAreThoseThatNameIt) {
    auto scene = scene_on_plane(settings());
    // A row of three that just touch, and one apart.
    for (const BodyId id : {0u, 1u, 2u}) need(scene->add_body({.id = id, .position_m = {0.998 * id, 0, 0.499}}));
    need(scene->add_body({.id = 3, .position_m = {10, 0, 0.499}}));
    run(*scene, 1, 1, workers_);
    EXPECT_EQ(scene->contacts().size(), 6u);
    EXPECT_EQ(scene->contacts_of(0).size(), 2u);
    EXPECT_EQ(scene->contacts_of(1).size(), 3u);
    EXPECT_EQ(scene->contacts_of(3).size(), 1u);
    for (const std::uint32_t index : scene->contacts_of(1)) {
        const Touch& touch = scene->contacts()[index].touch;
        EXPECT_TRUE(touch.body == 1 || (touch.other == 1 && !touch.other_is_obstacle));
    }
}

// The sums are those of the contacts in any order, also with two workers, and where bodies sleep.
TEST_P(Sensing, NormalForcesAreSummedUpByBody) {
    auto scene = scene_on_plane(settings());
    add_cube(*scene, 6, 0.999);
    need(scene->add_body({.id = 1000, .position_m = {60, 0, 0.5}}));
    std::vector<ExactSum> sums;
    for (const int ticks : {1, 20, 200}) {
        run(*scene, ticks, 2, workers_);
        std::vector<ExactSum> expected(scene->slot_count());
        for (const ContactReport& contact : scene->contacts()) {
            if (contact.normal_force_n < 0) continue;
            expected[scene->slot(contact.touch.body)].add(contact.normal_force_n);
            if (!contact.touch.other_is_obstacle) expected[scene->slot(contact.touch.other)].add(contact.normal_force_n);
        }
        Workers two(2);
        for (Workers* workers : {&workers_, &two}) {
            scene->sum_normal_forces(sums, *workers);
            EXPECT_EQ(sums, expected) << ticks;
        }
        EXPECT_GT(sums[scene->slot(0)].value(), 0);
    }
    EXPECT_EQ(scene->asleep(1000), GetParam() == EngineKind::Blocks);
}

TEST_P(Sensing, RemovingABodyEndsItsTouches) {
    auto scene = scene_on_plane(settings());
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0.499}}));
    need(scene->add_body({.id = 1, .position_m = {0.998, 0, 0.499}}));
    run(*scene, 1, 1, workers_);
    ASSERT_EQ(scene->events().size(), 3u);
    need(scene->remove_body(1));
    EXPECT_FALSE(scene->has(1));
    EXPECT_EQ(scene->body_count(), 1u);
    run(*scene, 1, 1, workers_);
    const std::vector<TouchEvent> events(scene->events().begin(), scene->events().end());
    EXPECT_EQ(events, (std::vector<TouchEvent>{{{0, 1, false}, false}, {{1, 0, true}, false}}));
    EXPECT_EQ(scene->contacts().size(), 1u);
    need(scene->add_body({.id = 1, .position_m = {5, 0, 0.499}}));
    run(*scene, 1, 1, workers_);
    EXPECT_EQ(scene->contacts().size(), 2u);
}

INSTANTIATE_TEST_SUITE_P(Engines, Sensing, testing::Values(EngineKind::Blocks, EngineKind::Hash, EngineKind::Ode), [](const auto& test) {
    return test.param == EngineKind::Blocks ? "Blocks" : test.param == EngineKind::Hash ? "Hash" : "Ode";
});

class Sleep : public testing::Test {
  protected:
    Workers workers_{1};
};

TEST_F(Sleep, RestingPileFallsAsleepAndCostsNoBlocks) {
    auto scene = scene_on_plane();
    add_cube(*scene, 10);
    run(*scene, 200, 2, workers_);
    const auto report = need(scene->step(kTick, 2, workers_));
    EXPECT_EQ(report.awake_bodies, 0u);
    EXPECT_TRUE(scene->asleep(555));
    EXPECT_EQ(scene->kinetic_energy_j(), 0);
    // Touches are remembered.
    EXPECT_GT(scene->contacts_of(555).size(), 4u);
    const Digest digest = scene->digest();
    run(*scene, 10, 2, workers_);
    EXPECT_EQ(scene->digest(), digest);
}

TEST_F(Sleep, WakesWhenHitPushedOrUndermined) {
    for (const int what : {0, 1, 2}) {
        auto scene = scene_on_plane();
        add_cube(*scene, 3);
        run(*scene, 200, 2, workers_);
        ASSERT_TRUE(scene->asleep(26));
        if (what == 0) need(scene->add_body({.id = 100, .position_m = {0.5, 0.5, 5}, .linear_velocity_m_s = {0, 0, -5}}));
        if (what == 1) need(scene->set_wrench(26, {100, 0, 0}, {}));
        if (what == 2) need(scene->remove_body(8));
        run(*scene, 120, 2, workers_);
        const BodyId moved = what == 0 ? 18 : 26;
        const double at = what == 0 ? 0 : 2;
        EXPECT_GT(length(scene->state(moved).position_m - Vec3{at, at, 2.5}), 0.005) << what;
    }
}

// A body that falls on sleepers wakes those around and is carried. Damped, for balls that nothing stops roll for ever.
TEST_F(Sleep, OnlyWhatIsNearIsAwake) {
    auto scene = scene_on_plane({.linear_damping_per_s = 1, .angular_damping_per_s = 2});
    BodyId id = 0;
    for (int x = 0; x < 60; ++x)
        for (int y = 0; y < 4; ++y) need(scene->add_body({.id = id++, .position_m = {1.0 * x, 1.0 * y, 0.5}}));
    run(*scene, 100, 2, workers_);
    ASSERT_EQ(need(scene->step(kTick, 2, workers_)).awake_bodies, 0u);
    need(scene->add_body({.id = 1000, .position_m = {1.5, 1.5, 1.3}}));
    std::size_t most = 0;
    for (int tick = 0; tick < 720; ++tick) most = std::max(most, need(scene->step(kTick, 2, workers_)).awake_bodies);
    EXPECT_LT(most, 150u);
    EXPECT_GT(most, 20u);
    EXPECT_GT(scene->state(1000).position_m.z, 1.1);
    EXPECT_EQ(need(scene->step(kTick, 2, workers_)).awake_bodies, 0u);
}

}  // namespace
}  // namespace meld::physics
