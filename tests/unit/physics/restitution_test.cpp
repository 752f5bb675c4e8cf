// Bounces against formulas: energy, friction in a bounce, blows that go through touching balls.
#include <gtest/gtest.h>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

class Restitution : public testing::Test {
  protected:
    std::unique_ptr<Scene> scene(float friction, float restitution, Vec3 gravity = {}) {
        auto made = make_scene({.gravity_m_s2 = gravity, .sleep_ticks = 0});
        material_ = need(made->add_material({.friction = friction, .restitution = restitution}));
        return made;
    }
    std::uint8_t material_ = 0;
    Workers workers_{1};
};

// A ball meets one at rest at the impact parameter b: along the line of centres they exchange velocities, across nothing happens.
TEST_F(Restitution, ObliqueElasticHitsKeepTheirEnergy) {
    for (const double b : {0.0, 0.3, 0.6, 0.9})
        for (const int substeps : {1, 2, 4}) {
            auto balls = scene(0, 1);
            need(balls->add_body({.id = 0, .position_m = {-2, b, 0}, .linear_velocity_m_s = {5, 0, 0}, .material = material_}));
            need(balls->add_body({.id = 1, .material = material_}));
            const double energy = balls->kinetic_energy_j();
            run(*balls, 240, substeps, workers_);
            EXPECT_NEAR(balls->kinetic_energy_j(), energy, 1e-5 * energy) << b << ", " << substeps;
            const Vec3 hit = balls->state(1).linear_velocity_m_s, left = balls->state(0).linear_velocity_m_s;
            EXPECT_NEAR(dot(hit, left), 0, 1e-3) << b;
            EXPECT_NEAR(length(hit), 5 * std::sqrt(1 - b * b), 0.1) << b;
        }
}

// A thousand balls for 20 s.
TEST_F(Restitution, ElasticGasKeepsItsTemperature) {
    auto gas = scene(0, 1);
    const int wide = 10;
    for (const Vec3 n : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
        need(gas->add_obstacle(Plane{n, -0.5}, material_));
        need(gas->add_obstacle(Plane{-n, 0.5 - wide}, material_));
    }
    BodyId id = 0;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> speed(-2, 2);
    for (int z = 0; z < wide; ++z)
        for (int y = 0; y < wide; ++y)
            for (int x = 0; x < wide; ++x)
                need(gas->add_body({.id = id++,
                                    .position_m = {0.9 * x, 0.9 * y, 0.9 * z},
                                    .linear_velocity_m_s = {speed(random), speed(random), speed(random)},
                                    .radius_m = 0.3,
                                    .material = material_}));
    const double energy = gas->kinetic_energy_j();
    run(*gas, 4800, 2, workers_);
    EXPECT_NEAR(gas->kinetic_energy_j(), energy, 1e-5 * energy);
}

// While it slips, friction takes mu (1 + e) of the approach speed from the ball's way along the ground.
TEST_F(Restitution, FrictionInABounceIsCoulombs) {
    for (const double e : {0.2, 0.5, 0.9}) {
        const double mu = 0.3;
        auto ball = scene(static_cast<float>(mu), static_cast<float>(e));
        need(ball->add_obstacle(Plane{}, material_));
        need(ball->add_body({.id = 0, .position_m = {0, 0, 1}, .linear_velocity_m_s = {5, 0, -2}, .material = material_}));
        run(*ball, 120, 2, workers_);
        const BodyState after = ball->state(0);
        EXPECT_NEAR(after.linear_velocity_m_s.z, 2 * e, 1e-4) << e;
        EXPECT_NEAR(after.linear_velocity_m_s.x, 5 - mu * (1 + e) * 2, 1e-4) << e;
        // The same impulse turns the ball: m r v = I w.
        EXPECT_NEAR(after.angular_velocity_rad_s.y * 0.5, (5 - after.linear_velocity_m_s.x) / 0.4, 1e-3) << e;
    }
}

// With much friction it leaves rolling, at 5/7 of its speed along the ground.
TEST_F(Restitution, RoughBallsLeaveRolling) {
    auto ball = scene(2, 0.8f);
    need(ball->add_obstacle(Plane{}, material_));
    need(ball->add_body({.id = 0, .position_m = {0, 0, 1}, .linear_velocity_m_s = {1, 0, -4}, .material = material_}));
    run(*ball, 60, 2, workers_);
    EXPECT_NEAR(ball->state(0).linear_velocity_m_s.x, 5.0 / 7, 1e-4);
    EXPECT_NEAR(ball->state(0).angular_velocity_rad_s.y * 0.5, 5.0 / 7, 1e-4);
}

TEST_F(Restitution, TouchingCradlePassesTheBlowOn) {
    auto cradle = scene(0, 1);
    for (BodyId id = 0; id < 5; ++id) need(cradle->add_body({.id = id, .position_m = {double(id), 0, 0}, .material = material_}));
    need(cradle->add_body({.id = 5, .position_m = {-2, 0, 0}, .linear_velocity_m_s = {3, 0, 0}, .material = material_}));
    run(*cradle, 240, 2, workers_);
    EXPECT_NEAR(cradle->state(4).linear_velocity_m_s.x, 3, 1e-3);
    for (const BodyId id : {5u, 0u, 1u, 2u, 3u}) EXPECT_NEAR(cradle->state(id).linear_velocity_m_s.x, 0, 1e-3) << id;
}

// Heights after bounces are e^2, e^4, e^6 of the first, with what symplectic steps lose.
TEST_F(Restitution, HeightsShrinkByTheSquareOfRestitution) {
    auto ball = scene(0.5f, 0.8f, {0, 0, -9.81});
    need(ball->add_obstacle(Plane{}, material_));
    need(ball->add_body({.id = 0, .position_m = {0, 0, 2.5}, .material = material_}));
    double expected = 2, highest = 0, before = -1;
    int bounces = 0;
    for (int tick = 0; tick < 1200 && bounces < 4; ++tick) {
        run(*ball, 1, 2, workers_);
        const BodyState state = ball->state(0);
        const double up = state.linear_velocity_m_s.z;
        if (before < 0 && up > 0) {
            if (bounces > 0) {
                EXPECT_NEAR(highest, expected, 0.02 * expected) << bounces;
            }
            ++bounces, expected *= 0.64, highest = 0;
        }
        if (bounces > 0) highest = std::max(highest, state.position_m.z - 0.5);
        before = up;
    }
    EXPECT_EQ(bounces, 4);
}

// A pile of bouncing balls comes to rest, and its weight rests on the ground.
TEST_F(Restitution, BouncingPilesComeToRest) {
    auto pile = scene(0.5f, 0.5f, {0, 0, -9.81});
    need(pile->add_obstacle(Plane{}, material_));
    for (BodyId id = 0; id < 64; ++id)
        need(pile->add_body(
            {.id = id, .position_m = {1.02 * (id % 4), 1.02 * (id / 4 % 4), 0.6 + 1.05 * (id / 16)}, .material = material_}));
    run(*pile, 1200, 2, workers_);
    double weight = 0;
    for (const ContactReport& contact : pile->contacts())
        if (contact.touch.other_is_obstacle) weight += contact.normal_force_n;
    EXPECT_NEAR(weight, 64 * 9.81, 0.02 * 64 * 9.81);
}

}  // namespace
}  // namespace meld::physics
