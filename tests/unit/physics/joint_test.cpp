// Joints against mechanics: pendulums, chains, motors, limits, loops.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "physics/scene/scene.h"
#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

constexpr double kPi = std::numbers::pi;

Settings wakeful(Vec3 gravity = {0, 0, -kGravity}) { return settings_with(gravity, 0); }

double energy(const Scene& scene) { return scene.kinetic_energy_j() + scene.potential_energy_j(); }

// Where a point that a body carries is now.
Vec3 carried(const Scene& scene, BodyId body, Vec3 own) {
    const BodyState state = scene.state(body);
    return state.position_m + rotate(state.orientation, own);
}

// A ball on a hinge in a fixed one, this far from it.
std::unique_ptr<Scene> pendulum(Vec3 arm_m, JointSpec joint = {}) {
    auto scene = make_scene(wakeful());
    need(scene->add_body({.id = 0, .position_m = {0, 0, 5}, .radius_m = 0.1, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = Vec3{0, 0, 5} + arm_m, .radius_m = 0.1}));
    joint.first = 0, joint.second = 1, joint.anchor_m = {0, 0, 5}, joint.axis = {0, 1, 0};
    need(scene->add_joint(joint));
    return scene;
}

TEST(Joints, APendulumSwingsInItsTimeAndKeepsItsEnergy) {
    // Let go at 5 degrees from below.
    const double arm = 1, tilt = 5 * kPi / 180;
    auto scene = pendulum({arm * std::sin(tilt), 0, -arm * std::cos(tilt)});
    Workers workers(1);
    std::vector<double> crossings;
    double before = scene->state(1).position_m.x;
    for (int tick = 1; tick <= 2400; ++tick) {
        run(*scene, 1, 2, workers);
        const double now = scene->state(1).position_m.x;
        if (before < 0 && now >= 0) crossings.push_back((tick - now / (now - before)) * kTick);
        before = now;
    }
    ASSERT_GE(crossings.size(), 4u);
    const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
    const double inertia = arm * arm + 0.4 * 0.01, exact = 2 * kPi * std::sqrt(inertia / (kGravity * arm)) * (1 + tilt * tilt / 16);
    EXPECT_NEAR(period, exact, 0.002 * exact);
}

TEST(Joints, APendulumThatFallsFromLevelComesBackAsHigh) {
    for (const double arm : {0.5, 1.0, 3.0}) {
        auto scene = pendulum({arm, 0, 0});
        Workers workers(1);
        const double start = energy(*scene);
        double highest = 0, worst = 0, longest = 0;
        for (int tick = 0; tick < 2400; ++tick) {
            run(*scene, 1, 2, workers);
            worst = std::max(worst, std::abs(energy(*scene) - start));
            longest = std::max(longest, std::abs(length(scene->state(1).position_m - Vec3{0, 0, 5}) - arm));
            if (tick > 1200) highest = std::max(highest, scene->state(1).position_m.z);
        }
        EXPECT_LT(worst, 0.01 * kGravity * arm) << arm;
        EXPECT_LT(longest, 1e-5 * arm) << arm;
        EXPECT_GT(highest, 5 - 0.01 * arm) << arm;
        EXPECT_NEAR(scene->state(1).position_m.y, 0, 1e-5);
    }
}

// Capsules along x, each hinged to the one before, the first to a fixed body.
std::unique_ptr<Scene> chain(BodyId links, double last_kg, const Settings& settings) {
    auto scene = make_scene(settings);
    need(scene->add_body({.id = 0, .position_m = {-0.5, 0, 0}, .radius_m = 0.1, .fixed = true}));
    for (BodyId i = 1; i <= links; ++i) {
        const double x = i - 0.5;
        need(scene->add_body({.id = i,
                              .position_m = {x, 0, 0},
                              .orientation = {std::sqrt(0.5), 0, std::sqrt(0.5), 0},
                              .mass_kg = i == links ? last_kg : 1,
                              .shape = capsule_shape(0.05, 0.9)}));
        need(scene->add_joint({.first = i - 1, .second = i, .anchor_m = {x - 0.5, 0, 0}, .axis = {0, 1, 0}}));
    }
    return scene;
}

TEST(Joints, AChainWithAHeavyEndDoesNotStretchAndKeepsItsEnergy) {
    constexpr BodyId kLinks = 100;
    auto scene = chain(kLinks, 100, wakeful());
    Workers workers(1);
    const double start = energy(*scene);
    // What falls is counted from where all hangs straight down.
    const double scale = kGravity * 100 * kLinks;
    double worst = 0, stretched = 0;
    for (int tick = 0; tick < 1200; ++tick) {
        run(*scene, 1, 2, workers);
        worst = std::max(worst, std::abs(energy(*scene) - start));
        for (BodyId i = 2; i <= kLinks; ++i)
            stretched = std::max(stretched, length(carried(*scene, i - 1, {0, 0, 0.5}) - carried(*scene, i, {0, 0, -0.5})));
    }
    EXPECT_LT(worst, 0.01 * scale);
    EXPECT_LT(stretched, 1e-4);
}

TEST(Joints, AChainHangsStraightUnderAHeavyEnd) {
    constexpr BodyId kLinks = 100;
    Settings settings = wakeful({kGravity, 0, 0});
    auto scene = chain(kLinks, 100, settings);
    Workers workers(1);
    run(*scene, 240, 2, workers);
    EXPECT_NEAR(scene->state(kLinks).position_m.x, kLinks - 0.5, 1e-4 * kLinks);
    EXPECT_LT(speed(*scene, kLinks), 1e-3);
}

TEST(Joints, AMotorTurnsBothSidesByItsTorque) {
    for (const bool of_shapes : {false, true}) {
        auto scene = make_scene(wakeful({}));
        const BodyShape box = box_shape({1, 0.5, 0.25}, 0.01);
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0}, .mass_kg = 2, .shape = of_shapes ? std::optional(box) : std::nullopt}));
        need(scene->add_body({.id = 1, .position_m = {0, 0, 2}, .mass_kg = 3, .shape = of_shapes ? std::optional(box) : std::nullopt}));
        need(scene->add_joint(
            {.first = 0, .second = 1, .anchor_m = {0, 0, 1}, .axis = {0, 0, 1}, .strength = 0.1, .drive = {JointDrive::Kind::Motor, 50}}));
        Workers workers(1);
        run(*scene, 240, 2, workers);
        const double first = of_shapes ? 2 * box.inertia_per_kg_m2().z : 2 * 0.4 * 0.25, second = 1.5 * first;
        EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, -0.1 / first, 1e-4 / first);
        EXPECT_NEAR(scene->state(1).angular_velocity_rad_s.z, 0.1 / second, 1e-4 / second);
        EXPECT_LT(length(scene->momentum()), 1e-5);
        EXPECT_LT(length(scene->angular_momentum()), 1e-4);
        const auto joint = scene->joint(1, 0);
        ASSERT_TRUE(joint);
        EXPECT_NEAR(joint->speed, 0.1 / first + 0.1 / second, 1e-3);
        EXPECT_NEAR(joint->place, 0.5 * joint->speed, 0.005 * joint->speed);
    }
}

TEST(Joints, AMotorThatIsStrongEnoughRunsAtItsSpeed) {
    auto scene = pendulum({1, 0, 0});
    need(scene->drive_joint(0, 1, {JointDrive::Kind::Motor, 2}));
    EXPECT_EQ(scene->joint_count(), 1u);
    auto strong = pendulum({1, 0, 0}, {.strength = 50, .drive = {JointDrive::Kind::Motor, 2}});
    Workers workers(1);
    run(*strong, 1200, 2, workers);
    // At full torque it would be slower by its give in its response time.
    EXPECT_NEAR(strong->joint(0, 1)->speed, 2, 0.2 * 1e-3 / 0.02);
    // It takes 2 / (50 + 9.81) s to come to its speed.
    EXPECT_NEAR(strong->joint(0, 1)->place, 10 - 2 / 59.81, 0.01);
    // Weaker than the weight, it lets the arm fall.
    run(*scene, 100, 2, workers);
    EXPECT_GT(scene->state(1).position_m.x, -0.99);
    EXPECT_LT(scene->state(1).position_m.z, 4.9);
}

TEST(Joints, AMotorThatIsToRunFasterThanAnythingCanGivesAllItHas) {
    for (const JointDrive::Kind kind : {JointDrive::Kind::Motor, JointDrive::Kind::Servo}) {
        std::vector<double> speeds;
        for (const double target : {1e3, 1e18}) {
            auto scene = make_scene(wakeful({}));
            need(scene->add_body({.id = 0, .position_m = {0, 0, 0}, .fixed = true}));
            need(scene->add_body({.id = 1, .position_m = {1, 0, 0}}));
            need(scene->add_joint(
                {.first = 0, .second = 1, .anchor_m = {0.5, 0, 0}, .axis = {0, 1, 0}, .strength = 40, .drive = {kind, target}}));
            Workers workers(1);
            run(*scene, 20, 2, workers);
            speeds.push_back(scene->joint(0, 1)->speed);
        }
        EXPECT_GT(speeds[0], 5);
        EXPECT_NEAR(speeds[1], speeds[0], 1e-5 * speeds[0]);
    }
}

TEST(Joints, AServoHoldsItsAngleAndABrakeHoldsWhereItIs) {
    auto scene = pendulum({1, 0, 0}, {.strength = 40, .servo_speed = 3, .drive = {JointDrive::Kind::Servo, -1}});
    Workers workers(1);
    run(*scene, 480, 2, workers);
    EXPECT_NEAR(scene->joint(0, 1)->place, -1, 1e-3);
    EXPECT_NEAR(scene->state(1).position_m.z, 5 + std::sin(1), 2e-3);
    need(scene->drive_joint(1, 0, {JointDrive::Kind::Brake, 0}));
    run(*scene, 480, 2, workers);
    EXPECT_NEAR(scene->joint(0, 1)->place, -1, 2e-3);
    need(scene->drive_joint(1, 0, {JointDrive::Kind::Coast, 0}));
    run(*scene, 160, 2, workers);
    EXPECT_GT(scene->joint(0, 1)->place, 0);
}

TEST(Joints, ALimitStopsWhatFallsAgainstIt) {
    auto scene = pendulum({1, 0, 0}, {.lower = -0.2, .upper = 0.5});
    Workers workers(1);
    double farthest = 0;
    for (int tick = 0; tick < 480; ++tick) {
        run(*scene, 1, 2, workers);
        farthest = std::max(farthest, scene->joint(0, 1)->place);
    }
    EXPECT_NEAR(farthest, 0.5, 1e-4);
    EXPECT_NEAR(scene->joint(0, 1)->place, 0.5, 1e-4);
    EXPECT_LT(speed(*scene, 1), 1e-3);
    // Pushed up, it leaves the limit and stops at the other one.
    need(scene->set_wrench(1, {0, 0, 30}, {}));
    run(*scene, 480, 2, workers);
    EXPECT_NEAR(scene->joint(0, 1)->place, -0.2, 1e-4);
}

TEST(Joints, ASliderKeepsItsAxisAndTurnsNothing) {
    auto scene = make_scene(wakeful());
    const Vec3 axis{0.6, 0, -0.8};
    need(scene->add_body({.id = 0, .position_m = {0, 0, 5}, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {0.9, 0.3, 4}, .shape = box_shape({1, 0.5, 0.25}, 0.01)}));
    need(scene->add_joint({.kind = JointKind::Slider, .first = 0, .second = 1, .anchor_m = {0, 0, 5}, .axis = axis, .upper = 4}));
    need(scene->set_wrench(1, {0, 3, 0}, {1, 2, 0.5}));
    Workers workers(1);
    run(*scene, 120, 2, workers);
    const double way = 0.5 * 0.8 * kGravity * 0.25;
    EXPECT_NEAR(scene->joint(0, 1)->place, way, 0.01 * way);
    const BodyState state = scene->state(1);
    const Vec3 off = (state.position_m - Vec3{0.9, 0.3, 4}) - scene->joint(0, 1)->place * axis;
    EXPECT_LT(length(off), 1e-5);
    EXPECT_LT(length(Vec3{state.orientation.x, state.orientation.y, state.orientation.z}), 1e-5);
    run(*scene, 240, 2, workers);
    EXPECT_NEAR(scene->joint(0, 1)->place, 4, 1e-4);
}

TEST(Joints, ASpringSwingsInItsTime) {
    auto scene = make_scene(wakeful({}));
    need(scene->add_body({.id = 0, .position_m = {0, 0, 5}, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {2, 0, 5}, .linear_velocity_m_s = {1, 0, 0}, .mass_kg = 2}));
    need(scene->add_joint({.kind = JointKind::Slider, .first = 0, .second = 1, .anchor_m = {0, 0, 5}, .axis = {1, 0, 0}, .stiffness = 32}));
    // A frequency of 4 rad/s: a quarter of a turn takes pi / 8 s.
    Workers workers(1);
    double farthest = 0;
    int at = 0;
    for (int tick = 1; tick <= 150; ++tick) {
        run(*scene, 1, 4, workers);
        if (scene->joint(0, 1)->place > farthest) farthest = scene->joint(0, 1)->place, at = tick;
    }
    EXPECT_NEAR(at * kTick, kPi / 8, 0.01);
    EXPECT_NEAR(farthest, 0.25, 0.005);
}

TEST(Joints, ABallTurnsAboutAnyAxis) {
    auto scene = make_scene(wakeful());
    need(scene->add_body({.id = 0, .position_m = {0, 0, 5}, .radius_m = 0.1, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {1, 0, 5}, .linear_velocity_m_s = {0, 3, 0}, .radius_m = 0.1}));
    need(scene->add_joint({.kind = JointKind::Ball, .first = 0, .second = 1, .anchor_m = {0, 0, 5}}));
    Workers workers(1);
    const double start = energy(*scene);
    for (int tick = 0; tick < 1200; ++tick) {
        run(*scene, 1, 2, workers);
        EXPECT_NEAR(length(carried(*scene, 1, {-1, 0, 0}) - Vec3{0, 0, 5}), 0, 1e-5);
    }
    EXPECT_NEAR(energy(*scene), start, 0.1);
}

// A ring of balls in a plane, hinged across it: its last three rows follow from the others.
std::unique_ptr<Scene> ring(int balls, const Settings& settings, double strength = 0) {
    auto scene = make_scene(settings);
    const double radius = 0.5 / std::sin(kPi / balls);
    const auto at = [&](double i) { return Vec3{radius * std::cos(2 * kPi * i / balls), 0, radius * std::sin(2 * kPi * i / balls)}; };
    for (int i = 0; i < balls; ++i) need(scene->add_body({.id = static_cast<BodyId>(i), .position_m = at(i)}));
    for (int i = 0; i < balls; ++i)
        need(scene->add_joint({.first = static_cast<BodyId>(i),
                               .second = static_cast<BodyId>((i + 1) % balls),
                               .anchor_m = 0.5 * (at(i) + at(i + 1)),
                               .axis = {0, 1, 0},
                               .strength = strength}));
    return scene;
}

TEST(Joints, ALoopStaysClosed) {
    auto scene = ring(12, wakeful({}));
    std::vector<Vec3> start_m, middles;
    for (BodyId i = 0; i < 12; ++i) start_m.push_back(scene->state(i).position_m);
    for (BodyId i = 0; i < 12; ++i) middles.push_back(0.5 * (start_m[i] + start_m[(i + 1) % 12]));
    need(scene->set_state(0, {.position_m = scene->state(0).position_m, .linear_velocity_m_s = {-0.3, 0.1, 0.5}}));
    Workers workers(1);
    run(*scene, 1, 2, workers);
    const double start = scene->kinetic_energy_j();
    const Vec3 momentum = scene->momentum(), angular = scene->angular_momentum();
    double widest = 0, parted = 0;
    for (int tick = 0; tick < 480; ++tick) {
        run(*scene, 1, 2, workers);
        for (BodyId i = 0; i < 12; ++i) {
            const BodyId next = (i + 1) % 12;
            widest = std::max(widest, std::abs(scene->joint(i, next)->place));
            parted =
                std::max(parted, length(carried(*scene, i, middles[i] - start_m[i]) - carried(*scene, next, middles[i] - start_m[next])));
        }
    }
    EXPECT_GT(widest, 0.1);
    EXPECT_NEAR(scene->kinetic_energy_j(), start, 0.01 * start);
    EXPECT_LT(length(scene->momentum() - momentum), 1e-3);
    EXPECT_LT(length(scene->angular_momentum() - angular), 1e-2);
    EXPECT_LT(parted, 1e-4);
    // Round a closed loop, the turns of all hinges add up to none.
    double sum = 0;
    for (BodyId i = 0; i < 12; ++i) sum += scene->joint(i, (i + 1) % 12)->place;
    EXPECT_NEAR(sum, 0, 1e-4);
}

TEST(Joints, ARingOfServosStandsAndSleeps) {
    Settings settings;
    auto scene = ring(12, settings, 100);
    need(scene->add_obstacle(Plane{{0, 0, 1}, scene->state(9).position_m.z - 0.5}, 0));
    for (BodyId i = 0; i < 12; ++i) need(scene->drive_joint(i, (i + 1) % 12, {JointDrive::Kind::Brake, 0}));
    Workers workers(1);
    run(*scene, 480, 2, workers);
    EXPECT_NEAR(scene->state(3).position_m.z - scene->state(9).position_m.z, 2 * 0.5 / std::sin(kPi / 12), 0.01);
    EXPECT_TRUE(scene->asleep(0));
    need(scene->drive_joint(2, 3, {JointDrive::Kind::Coast, 0}));
    run(*scene, 5, 2, workers);
    EXPECT_FALSE(scene->asleep(9));
}

// Where a loop lands, limits take hold and let go many times in one substep.
TEST(Joints, LoopsOfLockedAndOfDrivenHingesLandInOnePiece) {
    struct Loop {
        int count;
        double limit, strength, speed;
    };
    for (const Loop& loop : {Loop{3, 0, 0, 0}, Loop{4, kPi, 400, -20}}) {
        auto scene = scene_on_plane(wakeful());
        const double radius = 0.5 / std::sin(kPi / loop.count);
        for (int i = 0; i < loop.count; ++i) {
            const double angle = 2 * kPi * i / loop.count;
            need(scene->add_body(
                {.id = static_cast<BodyId>(i), .position_m = {radius * std::cos(angle), 0, 3 + radius + radius * std::sin(angle)}}));
        }
        for (int i = 0; i < loop.count; ++i) {
            const int next = (i + 1) % loop.count;
            const auto one = static_cast<BodyId>(std::min(i, next)), other = static_cast<BodyId>(std::max(i, next));
            need(scene->add_joint({.first = one,
                                   .second = other,
                                   .anchor_m = 0.5 * (scene->state(one).position_m + scene->state(other).position_m),
                                   .axis = {0, 1, 0},
                                   .lower = -loop.limit,
                                   .upper = loop.limit,
                                   .strength = loop.strength,
                                   .drive = {loop.strength > 0 ? JointDrive::Kind::Motor : JointDrive::Kind::Coast, loop.speed}}));
        }
        Workers workers(1);
        double fastest = 0, widest = 0;
        for (int tick = 0; tick < 400; ++tick) {
            run(*scene, 1, 2, workers);
            for (int i = 0; i < loop.count; ++i) {
                const BodyState one = scene->state(static_cast<BodyId>(i)), other = scene->state(static_cast<BodyId>((i + 1) % loop.count));
                fastest = std::max(fastest, length(one.linear_velocity_m_s));
                widest = std::max(widest, length(one.position_m - other.position_m));
            }
        }
        // It falls by 3 m, and motors do no more than 20 rad/s at arms of a few metres.
        EXPECT_LT(fastest, 20) << loop.count;
        EXPECT_LT(widest, 1.001) << loop.count;
    }
}

// Motors press loops of hinges about different axes against their limits, and a corner against a fixed body, with any force. What this
// adds to the energy is no more than motors do on their ways.
TEST(Joints, ALoopThatCannotHoldFallsAndLands) {
    constexpr double kDegree = kPi / 180;
    for (const double strength : {1.0, 40.0}) {
        auto scene = scene_on_plane(wakeful());
        const auto at = [](BodyId i) { return Vec3{double(i % 2), double(i / 2), 3}; };
        for (BodyId i = 0; i < 9; ++i) {
            BodySpec body{.id = i, .position_m = at(i), .fixed = i == 0};
            if (i < 3) body.shape = box_shape({1, 1, 1}, 0.05);
            need(scene->add_body(body));
        }
        for (BodyId i = 1; i < 9; ++i)
            for (BodyId j = i + 1; j < 9; ++j) {
                if (length(at(i) - at(j)) > 1.001) continue;
                JointSpec joint{.first = i, .second = j, .anchor_m = 0.5 * (at(i) + at(j)), .axis = {0, 1, 0}};
                joint.lower = -kDegree, joint.upper = kDegree;
                joint.strength = strength, joint.drive = {JointDrive::Kind::Motor, 2};
                if (i == 2 && j == 3) joint.axis = {0, 0, 1}, joint.lower = -kPi / 2, joint.upper = 0;
                if (i == 3 && j == 5) joint = {.kind = JointKind::Ball, .first = i, .second = j, .anchor_m = joint.anchor_m};
                need(scene->add_joint(joint));
            }
        Workers workers(1);
        const double start = energy(*scene);
        double most = start;
        for (int tick = 0; tick < 400; ++tick) {
            run(*scene, 1, 2, workers);
            most = std::max(most, energy(*scene));
        }
        EXPECT_LT(most, start + 20) << strength;
        EXPECT_LT(scene->kinetic_energy_j(), 20) << strength;
    }
}

TEST(Joints, WhatTheyHeldWakesWhenItsPartnerIsRemoved) {
    auto scene = make_scene();
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0}, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {0, 0, -60}}));
    need(scene->add_joint({.first = 0, .second = 1, .anchor_m = {0, 0, -30}, .axis = {0, 1, 0}}));
    Workers workers(1);
    run(*scene, 480, 2, workers);
    EXPECT_TRUE(scene->asleep(1));
    need(scene->remove_body(0));
    run(*scene, 120, 2, workers);
    EXPECT_LT(scene->state(1).position_m.z, -61);
}

TEST(Joints, TheStateDoesNotDependOnTheNumberOfWorkers) {
    std::vector<Digest> digests;
    for (const int threads : {1, 2}) {
        Settings settings;
        auto scene = scene_on_plane(settings);
        add_falling_chains(*scene);
        Workers workers(threads);
        run(*scene, 240, 2, workers);
        digests.push_back(scene->digest());
    }
    EXPECT_EQ(digests[0], digests[1]);
}

TEST(Joints, EndWithABodyAndAreRefusedWhereTheyCannotBe) {
    auto scene = ring(5, wakeful());
    EXPECT_EQ(scene->joint_count(), 5u);
    EXPECT_TRUE(scene->joined(4, 0));
    EXPECT_FALSE(scene->add_joint({.first = 0, .second = 4}));
    EXPECT_FALSE(scene->add_joint({.first = 0, .second = 0}));
    EXPECT_FALSE(scene->add_joint({.first = 0, .second = 2, .axis = {}}));
    EXPECT_FALSE(scene->add_joint({.first = 0, .second = 2, .lower = 0.1}));
    Workers workers(1);
    run(*scene, 3, 2, workers);
    need(scene->remove_body(4));
    EXPECT_EQ(scene->joint_count(), 3u);
    EXPECT_TRUE(scene->joined_to(0).size() == 1 && scene->joined_to(0)[0] == 1);
    run(*scene, 3, 2, workers);
    EXPECT_FALSE(scene->joint(3, 4));
}

}  // namespace
}  // namespace meld::physics
