// How joints of bodies are drawn.
#include "runtime/show/picture/stage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace meld::picture {
namespace {

using world::JointLook;

// What is drawn of one joint between two balls of a diameter, the second a diameter along x. Anchors are given as they are in the world.
std::vector<render::Triangle> drawn(JointLook joint, const std::vector<bool>& shown = {true, true},
                                    const std::vector<std::array<double, 4>>& turns = {}) {
    joint.second_anchor[0] -= 1;
    const record::Drawn catoms{.ids = {3, 7}, .positions = {{0, 0, 0}, {1, 0, 0}}, .turns = turns, .joints = {joint}, .colours = {0, 0}};
    const world::World world;
    const Look look;
    Stage stage(catoms, world, true, 0, look);
    stage.show(shown);
    stage.surround();
    return stage.frame.scene.obstacles;
}

// The box around triangles.
struct Box {
    render::Vec low, high;
};
Box box_of(const std::vector<render::Triangle>& triangles) {
    Box box{render::Vec::Constant(1e9F), render::Vec::Constant(-1e9F)};
    for (const render::Triangle& triangle : triangles)
        for (const render::Vec& corner : triangle) box.low = box.low.cwiseMin(corner), box.high = box.high.cwiseMax(corner);
    return box;
}

TEST(DrawnJoints, AHingeIsAPinAlongItsAxis) {
    const auto pin = drawn({JointLook::Kind::Hinge, 3, 7, {0.5, 0, 0}, {0.5, 0, 0}, {0, 2, 0}});
    const auto [low, high] = box_of(pin);
    EXPECT_NEAR(high.y(), 0.6, 1e-3);
    EXPECT_NEAR(low.y(), -0.6, 1e-3);
    EXPECT_NEAR(high.z(), 0.1, 0.01);
    EXPECT_NEAR(high.x() - 0.5, 0.1, 0.01);
}

TEST(DrawnJoints, AnArmLeadsToAnAnchorThatIsElsewhere) {
    const std::size_t near = drawn({JointLook::Kind::Hinge, 3, 7, {0.5, 0, 0}, {0.5, 0, 0}, {0, 1, 0}}).size();
    const auto far = drawn({JointLook::Kind::Hinge, 3, 7, {0, 0, 0}, {0, 0, 0}, {0, 1, 0}});
    EXPECT_GT(far.size(), near);
    EXPECT_GT(box_of(far).high.x(), 0.99F);
}

TEST(DrawnJoints, ASliderIsARailAsLongAsItsWay) {
    const auto [low, high] = box_of(drawn({JointLook::Kind::Slider, 3, 7, {0.5, 0, 0}, {0.5, 0, 2}, {0, 0, 1}}));
    EXPECT_NEAR(low.z(), -0.6, 0.01);
    EXPECT_NEAR(high.z(), 2.6, 0.01);
}

TEST(DrawnJoints, ABallIsABall) {
    const auto ball = drawn({JointLook::Kind::Ball, 3, 7, {0.5, 0, 0}, {0.5, 0, 0}});
    EXPECT_EQ(ball.size(), 128U);
    for (const render::Triangle& triangle : ball)
        for (const render::Vec& corner : triangle) EXPECT_NEAR((corner - render::Vec(0.5F, 0, 0)).norm(), 0.18, 1e-3);
}

TEST(DrawnJoints, APinTurnsWithItsCatoms) {
    // A quarter of a turn about x: what is along y in the frame of a catom is along z in the world.
    const double half = std::sqrt(0.5);
    const std::array<double, 4> quarter{half, half, 0, 0};
    const auto [low, high] =
        box_of(drawn({JointLook::Kind::Hinge, 3, 7, {0.5, 0, 0}, {0.5, 0, 0}, {0, 1, 0}}, {true, true}, {quarter, quarter}));
    EXPECT_NEAR(high.z(), 0.6, 1e-3);
    EXPECT_NEAR(low.z(), -0.6, 1e-3);
    EXPECT_NEAR(high.y(), 0.1, 0.01);
}

TEST(DrawnJoints, OnlyThoseOfCatomsThatAreShown) {
    EXPECT_TRUE(drawn({JointLook::Kind::Ball, 3, 7, {0.5, 0, 0}, {0.5, 0, 0}}, {true, false}).empty());
    EXPECT_TRUE(drawn({JointLook::Kind::Ball, 3, 8, {0.5, 0, 0}, {0.5, 0, 0}}).empty());
}

}  // namespace
}  // namespace meld::picture
