// Joints that are the only one of their two bodies are solved four at once (lone_joints.h); an assembly solves them if anything else acts.
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <vector>

#include "physics/bodies/simd.h"
#include "physics/scene/scene.h"
#include "tests/unit/physics/scenes.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics {
namespace {

constexpr BodyId kPairs = 11;

// Pairs of balls and boxes of several masses that float, tumble and turn against each other; each third is held by a ball. Limits that no
// hinge comes near leave hinges to assemblies.
std::unique_ptr<Scene> pairs(double limit, const std::vector<BodyId>& chosen) {
    auto scene = make_scene(settings_with({}, 0));
    for (const BodyId i : chosen) {
        const double share = i / static_cast<double>(kPairs);
        const Vec3 at{4.0 * i, 0, 0};
        BodySpec one{.id = 2 * i, .position_m = at, .angular_velocity_rad_s = {1 - share, 2 * share, 0.5}, .mass_kg = 1 + share};
        BodySpec other{.id = 2 * i + 1, .position_m = at + Vec3{0.2 * share, 1.1, 0}, .angular_velocity_rad_s = {-1, share, 0.5}};
        if (i % 2 == 1) one.shape = box_shape({1, 1, 1}, 0.1), other.radius_m = 0.3;
        need(scene->add_body(one)), need(scene->add_body(other));
        JointSpec joint{.first = 2 * i, .second = 2 * i + 1, .anchor_m = at + Vec3{0.1, 0.5, 0.1 * share}, .axis = {1, share, 0.2}};
        if (i % 3 == 2)
            joint.kind = JointKind::Ball;
        else
            joint.lower = -limit, joint.upper = limit, joint.strength = 2;
        need(scene->add_joint(joint));
    }
    return scene;
}

std::unique_ptr<Scene> pairs(double limit) {
    std::vector<BodyId> all(kPairs);
    std::iota(all.begin(), all.end(), 0U);
    return pairs(limit, all);
}

JointState state_of(const Scene& scene, BodyId pair) { return scene.joint(2 * pair, 2 * pair + 1).value_or(JointState{}); }

constexpr double kNone = std::numeric_limits<double>::infinity(), kFar = 1e6;

TEST(LoneJoints, MoveBodiesAsAssembliesDo) {
    auto lone = pairs(kNone), in_assemblies = pairs(kFar);
    Workers workers(1);
    run(*lone, 240, 2, workers), run(*in_assemblies, 240, 2, workers);
    EXPECT_NE(lone->digest(), in_assemblies->digest()) << "an assembly has solved all of them";
    for (BodyId body = 0; body < 2 * kPairs; ++body) {
        const BodyState one = lone->state(body), other = in_assemblies->state(body);
        EXPECT_LT(length(one.position_m - other.position_m), 1e-5) << body;
        EXPECT_LT(length(one.angular_velocity_rad_s - other.angular_velocity_rad_s), 1e-4) << body;
    }
    for (BodyId i = 0; i < kPairs; ++i) EXPECT_NEAR(state_of(*lone, i).place, state_of(*in_assemblies, i).place, 1e-4) << i;
}

TEST(LoneJoints, HoldTogetherAndKeepEnergyAndMomentum) {
    auto scene = pairs(kNone);
    Workers workers(1);
    // The first step takes out what the joints do not let them do.
    run(*scene, 1, 2, workers);
    const double energy = scene->kinetic_energy_j();
    const Vec3 momentum = scene->momentum();
    run(*scene, 480, 2, workers);
    EXPECT_NEAR(scene->kinetic_energy_j(), energy, 1e-4 * energy);
    EXPECT_LT(length(scene->momentum() - momentum), 1e-4);
    for (const Joint& joint : scene->joints()) {
        const Scene::JointPlace place = scene->place_of(joint);
        EXPECT_LT(length(place.first_anchor_m - place.second_anchor_m), 1e-5);
    }
}

TEST(LoneJoints, GiveTheSameBitsWhoeverSolvesThem) {
    const SimdLevel best = simd_level();
    std::vector<Digest> digests;
    for (const SimdLevel level : {SimdLevel::Baseline, best})
        for (const int threads : {1, 2, 3}) {
            set_simd_level(level);
            auto scene = pairs(kNone);
            Workers workers(threads);
            run(*scene, 40, 2, workers);
            // Motors come and go, which an assembly has to do.
            for (const BodyId i : {0U, 4U, 7U}) need(scene->drive_joint(2 * i, 2 * i + 1, {JointDrive::Kind::Motor, 3}));
            run(*scene, 40, 2, workers);
            EXPECT_NEAR(state_of(*scene, 4).speed, 3, 0.1);
            for (const BodyId i : {0U, 7U}) need(scene->drive_joint(2 * i, 2 * i + 1, {}));
            run(*scene, 40, 2, workers);
            digests.push_back(scene->digest());
            set_simd_level(best);
        }
    for (const Digest& digest : digests) EXPECT_EQ(digest, digests.front());
}

// One that touches nothing has nothing to do in the second pass of a substep; one that is pushed has. Both share a batch with others.
TEST(LoneJoints, MoveAsIfTheyWereTheOnlyOnes) {
    const auto with_blow = [](const std::vector<BodyId>& chosen) {
        auto scene = pairs(kNone, chosen);
        // A ball that hits the second pair, and comes along with it.
        need(scene->add_body({.id = 100, .position_m = {4, -2.2, 0}, .linear_velocity_m_s = {0, 3, 0}, .mass_kg = 3}));
        Workers workers(1);
        run(*scene, 120, 2, workers);
        return scene;
    };
    std::vector<BodyId> all(kPairs);
    std::iota(all.begin(), all.end(), 0U);
    const auto together = with_blow(all);
    EXPECT_GT(length(together->state(2).linear_velocity_m_s), 0.5) << "the ball has missed";
    for (const BodyId i : {0U, 1U, 2U, 5U, 9U}) {
        const auto alone = with_blow({i});
        for (const BodyId body : {2 * i, 2 * i + 1}) {
            EXPECT_EQ(alone->state(body).position_m, together->state(body).position_m) << body;
            EXPECT_EQ(alone->state(body).angular_velocity_rad_s, together->state(body).angular_velocity_rad_s) << body;
        }
        EXPECT_EQ(state_of(*alone, i).place, state_of(*together, i).place) << i;
    }
}

TEST(LoneJoints, CountTurnsOfMoreThanHalfAStep) {
    std::vector<double> places;
    for (const double limit : {kNone, kFar}) {
        auto scene = make_scene(settings_with({}, 0));
        const Vec3 half{0, 0, 0.5};
        need(scene->add_body({.id = 0, .position_m = -half, .shape = box_shape({1, 1, 1}, 0.1)}));
        need(scene->add_body({.id = 1, .position_m = half, .angular_velocity_rad_s = {0, 0, 1.5 * std::numbers::pi / kTick}}));
        need(scene->add_joint({.first = 0, .second = 1, .anchor_m = {}, .axis = {0, 0, 1}, .lower = -limit, .upper = limit}));
        Workers workers(1);
        run(*scene, 24, 4, workers);
        places.push_back(scene->joint(0, 1).value_or(JointState{}).place);
    }
    EXPECT_GT(places[0], 24 * std::numbers::pi);
    EXPECT_NEAR(places[0], places[1], 1e-3);
}

// Dumbbells that turn about the middle of their hinge: each half is pulled by its mass, the square of the speed, and half of the length.
TEST(LoneJoints, CarryAndBreakAsAssembliesDo) {
    constexpr double kArm_m = 0.6, kSpeed = 4, kPull_n = kSpeed * kSpeed * kArm_m;
    for (const double limit : {kNone, kFar}) {
        auto scene = make_scene(settings_with({}, 0));
        for (BodyId i = 0; i < 6; ++i) {
            const Vec3 middle{4.0 * i, 0, 0}, half{0, kArm_m, 0};
            for (const BodyId second : {0U, 1U}) {
                const double sign = second == 0 ? -1 : 1;
                need(scene->add_body({.id = 2 * i + second,
                                      .position_m = middle + sign * half,
                                      .linear_velocity_m_s = {-sign * kSpeed * kArm_m, 0, 0},
                                      .angular_velocity_rad_s = {0, 0, kSpeed}}));
            }
            // The fourth one carries less than it has to.
            const double most = i == 3 ? 0.99 * kPull_n : 1.01 * kPull_n;
            need(scene->add_joint({.first = 2 * i,
                                   .second = 2 * i + 1,
                                   .anchor_m = middle,
                                   .axis = {0, 0, 1},
                                   .lower = -limit,
                                   .upper = limit,
                                   .breaking_force_n = most}));
        }
        Workers workers(1);
        run(*scene, 60, 2, workers);
        need(scene->solve_loads(workers));
        for (BodyId i = 0; i < 6; ++i) {
            const auto load = scene->joint_load(2 * i, 2 * i + 1);
            EXPECT_EQ(load.has_value(), i != 3) << i;
            EXPECT_NEAR(load.value_or(JointLoad{kPull_n}).tension_n, kPull_n, 0.002 * kPull_n) << i;
        }
    }
}

TEST(LoneJoints, SleepAndHoldWhenTheyWake) {
    auto scene = scene_on_plane();
    for (BodyId i = 0; i < 5; ++i) {
        const Vec3 at{40.0 * i, 0, 0.5}, way{0, 1, 0};
        for (const BodyId second : {0U, 1U})
            need(scene->add_body(
                {.id = 2 * i + second, .position_m = at + static_cast<double>(second) * way, .shape = box_shape({1, 1, 1}, 0.05)}));
        need(scene->add_joint({.first = 2 * i, .second = 2 * i + 1, .anchor_m = at + 0.5 * way, .axis = {1, 0, 0}}));
    }
    Workers workers(1);
    run(*scene, 240, 2, workers);
    for (BodyId body = 0; body < 10; ++body) EXPECT_TRUE(scene->asleep(body)) << body;
    // The others of the batch, in other blocks of space, go on sleeping.
    need(scene->add_body({.id = 100, .position_m = {40, -2, 0.5}, .linear_velocity_m_s = {0, 6, 0}, .mass_kg = 4}));
    run(*scene, 60, 2, workers);
    EXPECT_GT(scene->state(2).position_m.y, 0.1);
    for (const Joint& joint : scene->joints()) {
        const Scene::JointPlace place = scene->place_of(joint);
        EXPECT_LT(length(place.first_anchor_m - place.second_anchor_m), 1e-4) << joint.first;
    }
    EXPECT_TRUE(scene->asleep(8));
}

TEST(LoneJoints, GoOnFromASnapshotAsIfNothingHadHappened) {
    auto scene = pairs(kNone);
    Workers workers(1);
    run(*scene, 15, 2, workers);
    // An assembly solves some of a batch.
    for (const BodyId i : {0U, 4U, 7U}) need(scene->drive_joint(2 * i, 2 * i + 1, {JointDrive::Kind::Motor, 3}));
    run(*scene, 15, 2, workers);
    const SavedScene middle = saved(*scene);
    run(*scene, 30, 2, workers);
    const auto resumed = loaded(middle, make_scene(settings_with({}, 0)), workers);
    run(*resumed, 30, 2, workers);
    EXPECT_EQ(resumed->digest(), scene->digest());
    for (BodyId i = 0; i < kPairs; ++i) EXPECT_EQ(state_of(*resumed, i).place, state_of(*scene, i).place) << i;
}

}  // namespace
}  // namespace meld::physics
