// Composites that a fixed body carries, and touches that go on although the physics has ended them.
#include <gtest/gtest.h>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

TEST(CarriedComposites, StopWhatMovesWhenItIsConnected) {
    auto scene = make_scene();
    need(scene->add_body({.id = 0, .position_m = {0, 0, 9}, .fixed = true}));
    for (const BodyId body : {BodyId(1), BodyId(2)})
        need(scene->add_body({.id = body, .position_m = {double(body), 0, 9}, .angular_velocity_rad_s = {0, 0, 3}}));
    Workers workers(2);
    run(*scene, 24, 2, workers);
    EXPECT_LT(scene->state(2).linear_velocity_m_s.z, -0.9);
    need(scene->connect(1, 2));
    need(scene->connect(0, 1));
    const Vec3 before = scene->state(2).position_m;
    run(*scene, 24, 2, workers);
    for (const BodyId body : {BodyId(1), BodyId(2)}) {
        EXPECT_EQ(scene->state(body).linear_velocity_m_s, Vec3{});
        EXPECT_EQ(scene->state(body).angular_velocity_rad_s, Vec3{});
    }
    EXPECT_EQ(scene->state(2).position_m, before);
}

TEST(CarriedComposites, TouchesLastWithinThemAndAtRest) {
    // A fixed ball and a row of two beside it on the ground; then two that are connected and move, one of them beside a third.
    auto scene = make_scene();
    need(scene->add_obstacle(Plane{}, 0));
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .fixed = true}));
    for (BodyId body = 1; body < 3; ++body) need(scene->add_body({.id = body, .position_m = {double(body), 0, 0.5}}));
    for (BodyId body = 3; body < 6; ++body) need(scene->add_body({.id = body, .position_m = {double(body) + 5, 0, 9}}));
    need(scene->add_body({.id = 6, .position_m = {0, 1, 0.5}, .fixed = true}));
    const Touch row{1, 2, false}, wall{0, 1, false}, ground{1, 0, true}, beside{1, 6, false}, pair{3, 4, false}, third{4, 5, false};
    Workers workers(1);
    run(*scene, 1, 2, workers);
    for (const Touch& touch : {row, wall, ground, beside, pair, third}) EXPECT_FALSE(scene->lasts(touch)) << touch.body << touch.other;
    EXPECT_TRUE(scene->lasts({0, 6, false}));
    for (const auto& [one, other] : {std::pair{BodyId(0), BodyId(1)}, {BodyId(2), BodyId(1)}, {BodyId(3), BodyId(4)}})
        need(scene->connect(one, other));
    EXPECT_FALSE(scene->lasts(row)) << "before the step";
    EXPECT_EQ(scene->connections(), (std::vector<std::pair<BodyId, BodyId>>{{0, 1}, {1, 2}, {3, 4}}));
    run(*scene, 1, 2, workers);
    for (const Touch& touch : {row, wall, ground, beside, pair}) EXPECT_TRUE(scene->lasts(touch)) << touch.body << touch.other;
    EXPECT_FALSE(scene->lasts(third));
    need(scene->release(0, 1));
    run(*scene, 1, 2, workers);
    EXPECT_TRUE(scene->lasts(row));
    for (const Touch& touch : {wall, ground, beside}) EXPECT_FALSE(scene->lasts(touch)) << touch.body << touch.other;
    EXPECT_EQ(scene->connection_count(), 2u);
}

}  // namespace
}  // namespace meld::physics
