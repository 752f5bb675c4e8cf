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

// What a ball may fall on; each with its surface at z = 0.
enum class Ground { Plane, Box, Terrain, Mesh, Ball };

class Bouncing : public Restitution {
  protected:
    // Heights after each bounce of a ball that falls by `fall_m`, as ticks see them. Something accelerates it downwards: gravity, or a
    // force as strong.
    std::vector<double> heights(Ground ground, double fall_m, float restitution, int substeps, std::size_t bounces, bool by_force) {
        auto ball = scene(0, restitution, by_force ? Vec3{} : Vec3{0, 0, -9.81});
        switch (ground) {
            case Ground::Plane:
                need(ball->add_obstacle(Plane{}, material_));
                break;
            case Ground::Box:
                need(ball->add_obstacle(Box{.centre = {0, 0, -1}, .size_m = {4, 4, 2}}, material_));
                break;
            case Ground::Terrain:
                need(ball->add_obstacle(
                    Terrain{.origin = {-2, -2, 0}, .cell_m = 1, .columns = 5, .rows = 5, .heights_m = std::vector<double>(25)}, material_));
                break;
            case Ground::Mesh:
                need(ball->add_obstacle(Mesh{{{-3, -3, 0}, {3, -3, 0}, {0, 4, 0}}, {0, 2, 1}}, material_));
                break;
            case Ground::Ball:
                need(ball->add_body({.id = 1, .position_m = {0, 0, -0.5}, .material = material_, .fixed = true}));
        }
        need(ball->add_body({.id = 0, .position_m = {0, 0, 0.5 + fall_m}, .material = material_}));
        std::vector<double> found;
        double highest = 0, before = 0;
        for (int tick = 0; tick < 20000 && found.size() < bounces; ++tick) {
            if (by_force) need(ball->set_wrench(0, {0, 0, -9.81}, {}));
            run(*ball, 1, substeps, workers_);
            const BodyState state = ball->state(0);
            const double up = state.linear_velocity_m_s.z;
            if (up > 0 || before > 0) highest = std::max(highest, state.position_m.z - 0.5);
            if (before > 0 && up <= 0) found.push_back(std::exchange(highest, 0.0));
            before = up;
        }
        return found;
    }
};

// Thirty elastic bounces end as high as they began, whatever the substep; with less restitution, heights shrink by its square.
TEST_F(Bouncing, BallsKeepTheEnergyThatRestitutionLeavesThem) {
    for (const Ground ground : {Ground::Plane, Ground::Box, Ground::Terrain, Ground::Mesh, Ground::Ball})
        for (const bool by_force : {false, true})
            for (const int substeps : {1, 2, 5}) {
                if (by_force && ground != Ground::Plane) continue;
                for (const float e : {1.0f, 0.9f, 0.5f}) {
                    const std::size_t bounces = e == 1 ? 30 : e > 0.6f ? 10 : 3;
                    const std::vector<double> found = heights(ground, 5, e, substeps, bounces, by_force);
                    ASSERT_EQ(found.size(), bounces) << int(ground) << by_force << substeps << e;
                    double expected = 5;
                    for (const double height : found) {
                        expected *= static_cast<double>(e) * static_cast<double>(e);
                        EXPECT_NEAR(height, expected, 0.004 * expected) << int(ground) << by_force << substeps << e;
                    }
                }
            }
}

// Under a ceiling gravity pulls the other way on the way to it: no energy is won.
TEST_F(Bouncing, BallsBetweenFloorAndCeilingKeepTheirEnergy) {
    for (const int substeps : {1, 2, 5}) {
        auto ball = scene(0, 1, {0, 0, -9.81});
        need(ball->add_obstacle(Plane{}, material_));
        need(ball->add_obstacle(Plane{{0, 0, -1}, -3}, material_));
        need(ball->add_body({.id = 0, .position_m = {0, 0, 1}, .linear_velocity_m_s = {0, 0, 8}, .material = material_}));
        const auto energy = [&] { return ball->kinetic_energy_j() + 9.81 * ball->state(0).position_m.z; };
        const double before = energy();
        for (int tick = 0; tick < 4800; ++tick) {
            run(*ball, 1, substeps, workers_);
            // Velocities are those of the middle of a substep.
            ASSERT_NEAR(energy(), before, 0.01 * before) << tick << ", " << substeps;
        }
    }
}

// Balls that bounce off each other and the ground keep the energy that they have together.
TEST_F(Bouncing, ElasticGasInGravityKeepsItsEnergy) {
    auto gas = scene(0, 1, {0, 0, -9.81});
    const int wide = 4;
    for (const Vec3 n : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
        need(gas->add_obstacle(Plane{n, -0.5}, material_));
        need(gas->add_obstacle(Plane{-n, 0.5 - wide}, material_));
    }
    std::mt19937 random(11);
    std::uniform_real_distribution<double> speed(-2, 2);
    for (BodyId id = 0; id < wide * wide * wide; ++id)
        need(gas->add_body({.id = id,
                            .position_m = {0.9 * (id % wide), 0.9 * (id / wide % wide), 0.9 * (id / wide / wide)},
                            .linear_velocity_m_s = {speed(random), speed(random), speed(random)},
                            .radius_m = 0.3,
                            .material = material_}));
    const auto energy = [&] {
        double sum = gas->kinetic_energy_j();
        for (BodyId id = 0; id < wide * wide * wide; ++id) sum += 9.81 * (gas->state(id).position_m.z + 0.5);
        return sum;
    };
    const double before = energy();
    run(*gas, 2400, 2, workers_);
    EXPECT_NEAR(energy(), before, 0.01 * before);
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
