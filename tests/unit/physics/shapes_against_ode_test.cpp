// Boxes, cylinders, capsules and joints through our solver and through ODE, side by side over time, in small steps. ODE's boxes and
// cylinders have sharp edges, and ours are hardly rounded here.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/physics/two_engines.h"

namespace meld::physics {
namespace {

constexpr double kStep_s = 1e-3;

struct Both : BothEngines {
    explicit Both(Vec3 gravity = {0, 0, -kGravity}) : BothEngines(kStep_s, gravity) {}
};

TEST(ShapesAgainstOde, ABoxFliesAndTumblesAlike) {
    Both both;
    both.each([](Scene& scene) {
        need(scene.add_body(
            {.id = 0, .linear_velocity_m_s = {2, 1, 6}, .angular_velocity_rad_s = {2, 0.3, 1}, .shape = box_shape({1, 0.6, 0.3}, 1e-3)}));
    });
    EXPECT_LT(both.most_apart(1), 0.01);
    EXPECT_LT(both.turned(0), 0.03);
    EXPECT_GT(length(both.ours->state(0).position_m - Vec3{2, 1, 6 - kGravity / 2}), -1.0);
}

TEST(ShapesAgainstOde, ABoxSlidesAsFar) {
    Both both;
    both.each([](Scene& scene) {
        need(scene.add_obstacle(Plane{}, 0));
        need(scene.add_body({.id = 0, .position_m = {0, 0, 0.2}, .linear_velocity_m_s = {4, 0, 0}, .shape = box_shape({1, 1, 0.4}, 1e-3)}));
    });
    // v^2 / (2 mu g)
    const double way = 16 / (2 * 0.5 * kGravity);
    EXPECT_LT(both.most_apart(1.5), 0.02 * way);
    EXPECT_NEAR(both.ours->state(0).position_m.x, way, 0.02 * way);
    EXPECT_NEAR(both.odes->state(0).position_m.x, way, 0.02 * way);
    EXPECT_LT(both.turned(0), 0.01);
}

TEST(ShapesAgainstOde, ABoxTipsOrStandsOnASlopeAlike) {
    // Twice as high as wide, it tips where the slope is more than 1 in 2.
    for (const double slope : {0.45, 0.55}) {
        const double angle = std::atan(slope);
        Both both({kGravity * std::sin(angle), 0, -kGravity * std::cos(angle)});
        both.each([](Scene& scene) {
            const auto rough = need(scene.add_material({.friction = 2}));
            need(scene.add_obstacle(Plane{}, rough));
            need(scene.add_body({.id = 0, .position_m = {0, 0, 0.5}, .material = rough, .shape = box_shape({0.5, 0.5, 1}, 1e-3)}));
        });
        both.go(0.9);
        EXPECT_LT(both.turned(0), slope > 0.5 ? 0.1 : 0.01) << slope;
        EXPECT_LT(both.apart(0), slope > 0.5 ? 0.05 : 0.01) << slope;
        const double leans = 2 * std::asin(std::abs(both.ours->state(0).orientation.y));
        if (slope > 0.5)
            EXPECT_GT(leans, 0.3);
        else
            EXPECT_LT(leans, 0.01);
    }
}

TEST(ShapesAgainstOde, ACapsuleFallsLiesAndRolls) {
    Both both;
    both.each([](Scene& scene) {
        need(scene.add_obstacle(Plane{}, 0));
        // Along y, thrown along x.
        need(scene.add_body({.id = 0,
                             .position_m = {0, 0, 0.5},
                             .orientation = {std::sqrt(0.5), std::sqrt(0.5), 0, 0},
                             .linear_velocity_m_s = {2, 0, 0},
                             .shape = capsule_shape(0.2, 1.2)}));
    });
    EXPECT_LT(both.most_apart(2), 0.05);
    both.each([](Scene& scene) {
        const BodyState state = scene.state(0);
        EXPECT_NEAR(state.position_m.z, 0.2, 2e-3);
        EXPECT_NEAR(state.linear_velocity_m_s.x, 0.2 * state.angular_velocity_rad_s.y, 0.01);
        EXPECT_GT(state.linear_velocity_m_s.x, 1.2);
    });
}

TEST(ShapesAgainstOde, ACapsuleThatStandsAskewFallsOver) {
    Both both;
    both.each([](Scene& scene) {
        need(scene.add_obstacle(Plane{}, 0));
        need(scene.add_body(
            {.id = 0, .position_m = {0, 0, 0.58}, .orientation = turn_of(0.3, {0, 1, 0}), .shape = capsule_shape(0.2, 1.2)}));
    });
    both.go(0.5);
    EXPECT_LT(both.turned(0), 0.05);
    EXPECT_LT(both.apart(0), 0.02);
    both.go(2);
    both.each([](Scene& scene) { EXPECT_NEAR(scene.state(0).position_m.z, 0.2, 5e-3); });
}

// Lying along y.
const Quat kAlongY{std::sqrt(0.5), std::sqrt(0.5), 0, 0};

TEST(ShapesAgainstOde, ACylinderFliesAndTumblesAlike) {
    Both both;
    both.each([](Scene& scene) {
        need(scene.add_body(
            {.id = 0, .linear_velocity_m_s = {2, 1, 6}, .angular_velocity_rad_s = {2, 0.3, 1}, .shape = cylinder_shape(0.4, 1.5, 1e-3)}));
    });
    EXPECT_LT(both.most_apart(1), 0.01);
    EXPECT_LT(both.turned(0), 0.03);
}

TEST(ShapesAgainstOde, ACylinderSlidesAsFarOnItsCap) {
    Both both;
    both.each([](Scene& scene) {
        need(scene.add_obstacle(Plane{}, 0));
        need(scene.add_body(
            {.id = 0, .position_m = {0, 0, 0.2}, .linear_velocity_m_s = {4, 0, 0}, .shape = cylinder_shape(0.5, 0.4, 1e-3)}));
    });
    const double way = 16 / (2 * 0.5 * kGravity);
    EXPECT_LT(both.most_apart(1.5), 0.02 * way);
    EXPECT_NEAR(both.ours->state(0).position_m.x, way, 0.02 * way);
    EXPECT_LT(both.turned(0), 0.02);
}

TEST(ShapesAgainstOde, ACylinderTipsOrStandsOnASlopeAlike) {
    // Twice as high as wide.
    for (const double slope : {0.44, 0.56}) {
        const double angle = std::atan(slope);
        Both both({kGravity * std::sin(angle), 0, -kGravity * std::cos(angle)});
        both.each([](Scene& scene) {
            const auto rough = need(scene.add_material({.friction = 2}));
            need(scene.add_obstacle(Plane{}, rough));
            need(scene.add_body({.id = 0, .position_m = {0, 0, 0.5}, .material = rough, .shape = cylinder_shape(0.25, 1, 1e-3)}));
        });
        both.go(0.8);
        both.each([&](Scene& scene) {
            const double leans = std::acos(std::min(1.0, rotate(scene.state(0).orientation, {0, 0, 1}).z));
            if (slope > 0.5)
                EXPECT_GT(leans, 0.2) << slope;
            else
                EXPECT_LT(leans, 0.02) << slope;
        });
        EXPECT_LT(both.apart(0), slope > 0.5 ? 0.1 : 0.02) << slope;
    }
}

TEST(ShapesAgainstOde, ACylinderFallsLiesAndRolls) {
    Both both;
    both.each([](Scene& scene) {
        need(scene.add_obstacle(Plane{}, 0));
        need(scene.add_body({.id = 0,
                             .position_m = {0, 0, 0.5},
                             .orientation = kAlongY,
                             .linear_velocity_m_s = {2, 0, 0},
                             .shape = cylinder_shape(0.2, 1.2, 1e-3)}));
    });
    EXPECT_LT(both.most_apart(2), 0.05);
    both.each([](Scene& scene) {
        const BodyState state = scene.state(0);
        EXPECT_NEAR(state.position_m.z, 0.2, 2e-3);
        // Two thirds of the speed are left, as of every full cylinder.
        EXPECT_NEAR(state.linear_velocity_m_s.x, 4.0 / 3, 0.03);
        EXPECT_NEAR(state.linear_velocity_m_s.x, 0.2 * state.angular_velocity_rad_s.y, 0.01);
    });
}

TEST(ShapesAgainstOde, ACylinderThatStandsAskewFallsOver) {
    Both both;
    both.each([](Scene& scene) {
        need(scene.add_obstacle(Plane{}, 0));
        // Beyond the angle at which its middle is above its rim, 0.32.
        need(scene.add_body(
            {.id = 0, .position_m = {0, 0, 0.645}, .orientation = turn_of(0.5, {0, 1, 0}), .shape = cylinder_shape(0.2, 1.2, 1e-3)}));
    });
    both.go(0.5);
    EXPECT_LT(both.turned(0), 0.06);
    EXPECT_LT(both.apart(0), 0.03);
    both.go(2);
    both.each([](Scene& scene) { EXPECT_NEAR(scene.state(0).position_m.z, 0.2, 5e-3); });
}

TEST(ShapesAgainstOde, ACylinderStandsOnOtherShapesAndIsHitByThem) {
    // A cylinder on a box, which is an obstacle; a ball, a capsule and a second cylinder run into three more.
    Both both;
    both.each([](Scene& scene) {
        const auto smooth = need(scene.add_material({.friction = 0}));
        need(scene.add_obstacle(Box{{0, 0, 0.5}, {2, 2, 1}, {}}, smooth));
        need(scene.add_body({.id = 0, .position_m = {0.2, 0, 1.5}, .material = smooth, .shape = cylinder_shape(0.4, 1, 1e-3)}));
    });
    both.go(1);
    EXPECT_LT(both.apart(0), 2e-3);
    EXPECT_LT(both.turned(0), 1e-2);
    const Quat upright{};
    for (const auto& [shape, turn] : {std::pair(BodyShape({}, 0.5), upright), std::pair(capsule_shape(0.3, 2), upright),
                                      std::pair(cylinder_shape(0.5, 1, 1e-3), upright), std::pair(cylinder_shape(0.5, 1, 1e-3), kAlongY)}) {
        Both free(Vec3{});
        free.each([&, &of = shape, &as = turn](Scene& scene) {
            need(scene.add_body({.id = 0, .shape = cylinder_shape(0.4, 1.2, 1e-3)}));
            need(scene.add_body(
                {.id = 1, .position_m = {2, 0, 0}, .orientation = as, .linear_velocity_m_s = {-2, 0, 0}, .mass_kg = 2, .shape = of}));
        });
        free.go(1);
        // Neither bounces: both go on together with the momentum of the second. ODE notices them only once they overlap, and parts them.
        free.each([](Scene& scene) { EXPECT_NEAR(scene.momentum().x, -4, 1e-4); });
        EXPECT_NEAR(free.ours->state(0).linear_velocity_m_s.x, -4.0 / 3, 0.1);
        EXPECT_NEAR(free.odes->state(0).linear_velocity_m_s.x, -1.55, 0.25);
        EXPECT_LT(free.apart_now(), 0.25);
    }
}

// Boxes in a row along x, each hinged to the one before, the first to a fixed body.
void add_arm(Scene& scene, BodyId links, JointSpec joint, JointKind kind = JointKind::Hinge) {
    need(scene.add_body({.id = 0, .position_m = {-0.5, 0, 5}, .radius_m = 0.1, .fixed = true}));
    for (BodyId i = 1; i <= links; ++i) {
        need(scene.add_body({.id = i, .position_m = {i - 0.5, 0, 5}, .shape = box_shape({1, 0.2, 0.1}, 1e-3)}));
        joint.kind = kind, joint.first = i - 1, joint.second = i, joint.anchor_m = {i - 1.0, 0, 5}, joint.axis = {0, 1, 0};
        need(scene.add_joint(joint));
    }
}

TEST(JointsAgainstOde, APendulumSwingsAlike) {
    for (const JointKind kind : {JointKind::Hinge, JointKind::Ball}) {
        Both both;
        both.each([&](Scene& scene) { add_arm(scene, 1, {}, kind); });
        EXPECT_LT(both.most_apart(2), 0.03);
        EXPECT_LT(both.turned(1), 0.06);
    }
}

TEST(JointsAgainstOde, ADoublePendulumSwingsAlikeForAWhile) {
    Both both;
    both.each([](Scene& scene) { add_arm(scene, 2, {}); });
    EXPECT_LT(both.most_apart(1), 0.05);
    EXPECT_LT(both.turned(2), 0.1);
    EXPECT_NEAR(both.ours->joint(0, 1)->place, both.odes->joint(0, 1)->place, 0.05);
    EXPECT_NEAR(both.ours->joint(1, 2)->place, both.odes->joint(1, 2)->place, 0.1);
}

TEST(JointsAgainstOde, AnArmFallsToItsLimit) {
    Both both;
    both.each([](Scene& scene) { add_arm(scene, 1, {.lower = -1, .upper = 0.8}); });
    both.go(1.5);
    both.each([](Scene& scene) { EXPECT_NEAR(scene.joint(0, 1)->place, 0.8, 2e-3); });
    EXPECT_LT(both.apart(1), 2e-3);
}

TEST(JointsAgainstOde, AMotorLiftsAnArmAndAServoHoldsIt) {
    Both both;
    both.each([](Scene& scene) { add_arm(scene, 1, {.strength = 20, .response_s = 0.05, .drive = {JointDrive::Kind::Motor, -2}}); });
    both.go(0.4);
    EXPECT_NEAR(both.ours->joint(0, 1)->speed, -2, 0.02);
    EXPECT_NEAR(both.odes->joint(0, 1)->speed, -2, 0.02);
    EXPECT_NEAR(both.ours->joint(0, 1)->place, both.odes->joint(0, 1)->place, 0.02);
    both.each([](Scene& scene) { need(scene.drive_joint(0, 1, {JointDrive::Kind::Servo, 0.5})); });
    both.go(0.1);
    EXPECT_NEAR(both.ours->joint(0, 1)->place, both.odes->joint(0, 1)->place, 0.05);
    both.go(1.5);
    both.each([](Scene& scene) { EXPECT_NEAR(scene.joint(0, 1)->place, 0.5, 5e-3); });
    both.each([](Scene& scene) { need(scene.drive_joint(0, 1, {JointDrive::Kind::Coast, 0})); });
    EXPECT_LT(both.most_apart(0.5), 0.02);
}

TEST(JointsAgainstOde, AWeakMotorTurnsAFreePairByItsTorque) {
    Both both(Vec3{});
    both.each([](Scene& scene) {
        need(scene.add_body({.id = 0, .position_m = {0, 0, 0}, .mass_kg = 2, .shape = box_shape({1, 0.5, 0.25}, 1e-3)}));
        need(scene.add_body({.id = 1, .position_m = {0, 0, 2}, .mass_kg = 3, .shape = capsule_shape(0.2, 1)}));
        need(scene.add_joint(
            {.first = 0, .second = 1, .anchor_m = {0, 0, 1}, .axis = {0, 0, 1}, .strength = 0.1, .drive = {JointDrive::Kind::Motor, 50}}));
    });
    both.go(0.5);
    for (const BodyId body : {0u, 1u})
        EXPECT_NEAR(both.ours->state(body).angular_velocity_rad_s.z, both.odes->state(body).angular_velocity_rad_s.z, 1e-3);
    EXPECT_NEAR(both.ours->joint(0, 1)->speed, both.odes->joint(0, 1)->speed, 2e-3);
    EXPECT_LT(both.odes->state(0).angular_velocity_rad_s.z, 0);
}

TEST(JointsAgainstOde, ASliderFallsToItsLimit) {
    Both both;
    const Vec3 axis{0.6, 0, -0.8};
    both.each([&](Scene& scene) {
        need(scene.add_body({.id = 0, .position_m = {0, 0, 5}, .fixed = true}));
        need(scene.add_body({.id = 1, .position_m = {0.9, 0.3, 4}, .shape = box_shape({1, 0.5, 0.25}, 1e-3)}));
        need(scene.add_joint(
            {.kind = JointKind::Slider, .first = 0, .second = 1, .anchor_m = {0, 0, 5}, .axis = axis, .lower = -1, .upper = 2}));
    });
    both.go(0.5);
    const double way = 0.5 * 0.8 * kGravity * 0.25;
    both.each([&](Scene& scene) { EXPECT_NEAR(scene.joint(0, 1)->place, way, 0.01 * way); });
    EXPECT_LT(both.apart(1), 0.01);
    both.go(1.5);
    both.each([](Scene& scene) { EXPECT_NEAR(scene.joint(0, 1)->place, 2, 2e-3); });
    EXPECT_LT(both.turned(1), 2e-3);
}

TEST(JointsAgainstOde, ASpringSwingsAlike) {
    Both both;
    both.each([](Scene& scene) {
        need(scene.add_body({.id = 0, .position_m = {0, 0, 5}, .fixed = true}));
        need(scene.add_body({.id = 1, .position_m = {0, 0, 3}, .mass_kg = 2}));
        need(scene.add_joint({.kind = JointKind::Slider,
                              .first = 0,
                              .second = 1,
                              .anchor_m = {0, 0, 4},
                              .axis = {0, 0, 1},
                              .stiffness = 50,
                              .damping = 1,
                              .rest = 0.1}));
    });
    EXPECT_LT(both.most_apart(2), 0.02);
    // m g / k below where it is loose.
    both.go(20);
    both.each([](Scene& scene) { EXPECT_NEAR(scene.joint(0, 1)->place, 0.1 - 2 * kGravity / 50, 2e-3); });
}

TEST(JointsAgainstOde, LoadsAreTheSameAndBreakAtTheSameLink) {
    Both both;
    both.each([](Scene& scene) { add_arm(scene, 3, {.strength = 200, .drive = {JointDrive::Kind::Brake, 0}}); });
    both.go(0.5);
    both.each([&](Scene& scene) { need(scene.solve_loads(both.workers)); });
    both.go(0.1);
    both.each([&](Scene& scene) {
        need(scene.solve_loads(both.workers));
        for (BodyId i = 0; i < 3; ++i) {
            const auto load = scene.joint_load(i, i + 1);
            ASSERT_TRUE(load);
            const double hang = 3 - i;
            EXPECT_NEAR(load->force_n(), hang * kGravity, 0.02 * kGravity) << i;
            EXPECT_NEAR(load->torque_nm, hang * hang / 2 * kGravity, 0.02 * kGravity) << i;
        }
    });
    Both weak;
    weak.each([&](Scene& scene) {
        add_arm(scene, 3, {.strength = 200, .breaking_torque_nm = 3 * kGravity, .drive = {JointDrive::Kind::Brake, 0}});
        std::vector<ConnectionPair> broken;
        for (int step = 0; step < 100; ++step) {
            need(scene.step(kStep_s, 1, weak.workers));
            broken.insert(broken.end(), scene.broken_joints().begin(), scene.broken_joints().end());
        }
        EXPECT_EQ(broken, (std::vector<ConnectionPair>{{0, 1}}));
        EXPECT_EQ(scene.joint_count(), 2u);
    });
}

TEST(JointsAgainstOde, WhatOdeDoesNotHoldIsRefused) {
    auto scene = make_scene({.engine = EngineKind::Ode});
    need(scene->add_body({.id = 0, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {1, 0, 0}}));
    const JointSpec hinge{.first = 0, .second = 1, .anchor_m = {0.5, 0, 0}};
    JointSpec wide = hinge, half = hinge, spring = hinge;
    wide.lower = -4, wide.upper = 1, half.lower = -1, spring.lower = -1, spring.upper = 1, spring.stiffness = 1;
    for (const JointSpec& each : {wide, half, spring}) {
        const auto added = scene->add_joint(each);
        ASSERT_FALSE(added);
        EXPECT_NE(added.error().problem.find("which the engine Ode does not hold"), std::string::npos) << added.error().message();
    }
    need(scene->add_joint(hinge));
    auto hash = make_scene({.engine = EngineKind::Hash});
    need(hash->add_body({.id = 0, .fixed = true}));
    need(hash->add_body({.id = 1, .position_m = {1, 0, 0}}));
    EXPECT_FALSE(hash->add_joint(hinge));
    EXPECT_FALSE(hash->add_body({.id = 2, .position_m = {5, 0, 0}, .shape = capsule_shape(0.2, 1)}));
}

}  // namespace
}  // namespace meld::physics
