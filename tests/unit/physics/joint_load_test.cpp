// What joints carry, and where they break, against statics and mechanics.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "physics/scene/scene.h"
#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

Settings in_gravity(Vec3 gravity = {0, 0, -kGravity}) { return settings_with(gravity, 0); }

JointLoad load_of(Scene& scene, BodyId one, BodyId other, Workers& workers) {
    need(scene.solve_loads(workers));
    const auto load = scene.joint_load(one, other);
    EXPECT_TRUE(load);
    return load.value_or(JointLoad{});
}

// A ball of 2 kg, a metre beside a fixed one and hinged there.
std::unique_ptr<Scene> swing(JointSpec joint) {
    auto scene = make_scene(in_gravity());
    need(scene->add_body({.id = 0, .position_m = {0, 0, 5}, .radius_m = 0.1, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {1, 0, 5}, .radius_m = 0.1, .mass_kg = 2}));
    joint.first = 0, joint.second = 1, joint.anchor_m = {0, 0, 5}, joint.axis = {0, 1, 0};
    need(scene->add_joint(joint));
    return scene;
}
// Its weight along the arm, and m v^2 / r.
double pull_of_swing(const Scene& scene) {
    const BodyState state = scene.state(1);
    return 2 * (kGravity * (5 - state.position_m.z) + dot(state.linear_velocity_m_s, state.linear_velocity_m_s));
}

TEST(JointLoads, APendulumPullsByItsWeightAndItsSpeed) {
    for (const JointKind kind : {JointKind::Hinge, JointKind::Ball}) {
        auto scene = swing({.kind = kind});
        Workers workers(1);
        double most = 0;
        for (int step = 0; step < 1500; ++step) {
            need(scene->step(1e-3, 2, workers));
            const JointLoad load = load_of(*scene, 1, 0, workers);
            EXPECT_NEAR(load.tension_n, pull_of_swing(*scene), 0.1) << step;
            // The force is that of the middle of a step, and the line that of its end.
            EXPECT_LT(load.shear_n, 0.3) << step;
            EXPECT_LT(load.torque_nm, 1e-3) << step;
            most = std::max(most, load.tension_n);
        }
        EXPECT_NEAR(most, 3 * 2 * kGravity, 0.01 * 3 * 2 * kGravity);
    }
}

TEST(JointLoads, APendulumBreaksWhereItsPullIsWhatTheJointCarries) {
    for (const double limit_n : {15.0, 30.0, 45.0, 57.0}) {
        auto scene = swing({.breaking_force_n = limit_n});
        Workers workers(1);
        int step = 0;
        for (; step < 3000 && scene->broken_joints().empty(); ++step) {
            EXPECT_LT(pull_of_swing(*scene), 1.01 * limit_n);
            need(scene->step(1e-3, 2, workers));
        }
        EXPECT_NEAR(pull_of_swing(*scene), limit_n, 0.01 * limit_n);
        EXPECT_EQ(scene->broken_joints().size(), 1u);
        EXPECT_EQ(scene->joint_count(), 0u);
        EXPECT_FALSE(scene->joined(0, 1));
        EXPECT_FALSE(scene->joint_load(0, 1));
        // From then on it flies.
        const Vec3 v = scene->state(1).linear_velocity_m_s;
        for (int more = 0; more < 100; ++more) {
            need(scene->step(1e-3, 2, workers));
            EXPECT_TRUE(scene->broken_joints().empty());
        }
        EXPECT_LT(length(scene->state(1).linear_velocity_m_s - (v - Vec3{0, 0, 0.1 * kGravity})), 1e-3);
    }
    auto strong = swing({.breaking_force_n = 60});
    Workers workers(1);
    for (int step = 0; step < 3000; ++step) need(strong->step(1e-3, 2, workers));
    EXPECT_EQ(strong->joint_count(), 1u);
}

// Balls below each other, each hinged to the one above, the first to a fixed one.
std::unique_ptr<Scene> hanging(BodyId balls, double limit_n) {
    auto scene = make_scene(in_gravity());
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0}, .fixed = true}));
    for (BodyId i = 1; i <= balls; ++i) {
        need(scene->add_body({.id = i, .position_m = {0, 0, -1.0 * i}}));
        need(scene->add_joint({.first = i, .second = i - 1, .anchor_m = {0, 0, 0.5 - i}, .axis = {0, 1, 0}, .breaking_force_n = limit_n}));
    }
    return scene;
}

TEST(JointLoads, EachLinkOfAChainCarriesWhatHangsOnIt) {
    auto scene = hanging(10, 1000);
    Workers workers(1);
    run(*scene, 4, 2, workers);
    for (BodyId i = 1; i <= 10; ++i) {
        const JointLoad load = load_of(*scene, i - 1, i, workers);
        EXPECT_NEAR(load.tension_n, (11 - i) * kGravity, 1e-3) << i;
        EXPECT_NEAR(load.force_n(), load.tension_n, 1e-3);
    }
}

TEST(JointLoads, AChainThatCarriesTooMuchBreaksAtItsTopLink) {
    // With the lower limit the three uppermost carry too much, until the first of them has broken.
    for (const double limit_n : {9.5 * kGravity, 7.5 * kGravity}) {
        auto scene = hanging(10, limit_n);
        Workers workers(1);
        run(*scene, 1, 2, workers);
        ASSERT_EQ(scene->broken_joints().size(), 1u);
        EXPECT_EQ(scene->broken_joints()[0], (ConnectionPair{0, 1}));
        run(*scene, 240, 2, workers);
        EXPECT_EQ(scene->joint_count(), 9u);
        EXPECT_NEAR(scene->state(1).position_m.z - scene->state(10).position_m.z, 9, 1e-4);
        EXPECT_LT(scene->state(1).position_m.z, -4);
        need(scene->solve_loads(workers));
        run(*scene, 1, 2, workers);
        EXPECT_LT(load_of(*scene, 4, 5, workers).force_n(), 0.01);
    }
    auto strong = hanging(10, 10.01 * kGravity);
    Workers workers(1);
    run(*strong, 240, 2, workers);
    EXPECT_EQ(strong->joint_count(), 10u);
}

TEST(JointLoads, ABrakeAndASliderCarryTheTorqueOfAnArm) {
    for (const bool slider : {false, true})
        for (const double limit_nm : {1.95 * kGravity, 2.3 * kGravity}) {
            auto scene = make_scene(in_gravity());
            need(scene->add_body({.id = 0, .position_m = {0, 0, 5}, .radius_m = 0.1, .fixed = true}));
            need(scene->add_body({.id = 1, .position_m = {1, 0, 5}, .radius_m = 0.1, .mass_kg = 2}));
            JointSpec joint{.first = 0, .second = 1, .anchor_m = {0, 0, 5}, .axis = {0, 1, 0}, .breaking_torque_nm = limit_nm};
            if (slider)
                joint.kind = JointKind::Slider;
            else
                joint.strength = 100, joint.drive = {JointDrive::Kind::Brake, 0};
            need(scene->add_joint(joint));
            Workers workers(1);
            run(*scene, 240, 2, workers);
            need(scene->solve_loads(workers));
            run(*scene, 4, 2, workers);
            ASSERT_EQ(scene->joint_count(), limit_nm > 2 * kGravity ? 1u : 0u) << slider;
            if (scene->joint_count() == 0) continue;
            const JointLoad load = load_of(*scene, 0, 1, workers);
            EXPECT_NEAR(load.torque_nm, 2 * kGravity, 0.01 * kGravity) << slider;
            EXPECT_NEAR(load.shear_n, 2 * kGravity, 0.01 * kGravity) << slider;
        }
}

TEST(JointLoads, ALoadIsTheMeanOverTheStepsSinceTheLast) {
    auto scene = hanging(1, 1000);
    Workers workers(1);
    for (int step = 0; step < 8; ++step) {
        need(scene->set_wrench(1, {0, 0, step < 4 ? 0.0 : -8.0}, {}));
        run(*scene, 1, 2, workers);
    }
    EXPECT_NEAR(load_of(*scene, 0, 1, workers).tension_n, kGravity + 4, 1e-3);
    run(*scene, 1, 2, workers);
    EXPECT_NEAR(load_of(*scene, 0, 1, workers).tension_n, kGravity + 8, 1e-3);
    // What sleeps carries what it carried.
    EXPECT_NEAR(load_of(*scene, 0, 1, workers).tension_n, kGravity + 8, 1e-3);
}

TEST(JointLoads, WhatABrokenJointHeldCollides) {
    auto scene = make_scene(in_gravity());
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0}, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {0, 0, 1}}));
    need(scene->add_joint({.first = 0, .second = 1, .anchor_m = {0, 0, 0.5}, .axis = {0, 1, 0}, .breaking_force_n = 5}));
    Workers workers(1);
    run(*scene, 1, 2, workers);
    EXPECT_EQ(scene->joint_count(), 0u);
    EXPECT_TRUE(scene->contacts().empty());
    run(*scene, 60, 2, workers);
    EXPECT_NEAR(scene->state(1).position_m.z, 1, 0.01);
    EXPECT_EQ(scene->contacts().size(), 1u);
}

TEST(JointLoads, BreaksAreTheSameForAnyNumberOfWorkers) {
    std::vector<Digest> digests;
    std::vector<std::vector<ConnectionPair>> broken;
    for (const int threads : {1, 2}) {
        auto scene = scene_on_plane(settings_with({0, 0, -kGravity}));
        // They break as they land.
        add_falling_chains(*scene, {.breaking_force_n = 100, .breaking_torque_nm = 25});
        Workers workers(threads);
        broken.emplace_back();
        for (int tick = 0; tick < 240; ++tick) {
            run(*scene, 1, 2, workers);
            broken.back().insert(broken.back().end(), scene->broken_joints().begin(), scene->broken_joints().end());
        }
        digests.push_back(scene->digest());
        EXPECT_EQ(scene->joint_count() + broken.back().size(), 160u);
    }
    EXPECT_GT(broken[0].size(), 10u);
    EXPECT_LT(broken[0].size(), 150u);
    EXPECT_EQ(broken[0], broken[1]);
    EXPECT_EQ(digests[0], digests[1]);
}

TEST(JointLoads, TooManyJointsOfOneBodyAreNotCalledLoops) {
    auto scene = make_scene(in_gravity({}));
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0}}));
    for (BodyId i = 1; i <= 494; ++i) {
        const Vec3 at{2.0 * (i % 20), 2.0 * (i / 20), 3};
        need(scene->add_body({.id = i, .position_m = at}));
        need(scene->add_joint({.kind = JointKind::Ball, .first = 0, .second = i, .anchor_m = 0.5 * at}));
    }
    Workers workers(1);
    const auto step = scene->step(kTick, 1, workers);
    ASSERT_FALSE(step);
    EXPECT_NE(step.error().problem.find("body 0 has 494 joints (a body that moves has 493 at most)"), std::string::npos)
        << step.error().message();
    EXPECT_FALSE(scene->add_joint({.first = 1, .second = 2, .breaking_force_n = 0}));
}

}  // namespace
}  // namespace meld::physics
