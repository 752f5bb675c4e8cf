// The block engine against mechanics that can be written down: falling, sliding, rolling, bouncing, standing, conservation.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

class Mechanics : public testing::Test {
  protected:
    Workers workers_{1};
};

TEST_F(Mechanics, FreeFallFollowsTheParabola) {
    auto scene = make_scene();
    need(scene->add_body({.id = 3, .position_m = {0, 0, 100}, .linear_velocity_m_s = {1, -2, 5}}));
    const int ticks = 240, substeps = 2;
    run(*scene, ticks, substeps, workers_);
    const double t = ticks * kTick, h = kTick / substeps;
    const Vec3 p = scene->state(3).position_m;
    EXPECT_NEAR(p.x, t, 1e-5);
    EXPECT_NEAR(p.y, -2 * t, 1e-5);
    // The velocity is stepped first, so the fall is ahead of the parabola by g h t / 2.
    EXPECT_NEAR(p.z, 100 + 5 * t - kGravity * t * t / 2 - kGravity * h * t / 2, 2e-4);
    EXPECT_NEAR(scene->acceleration(3).z, -kGravity, 1e-2);
}

TEST_F(Mechanics, DampingLosesItsShareASecond) {
    for (const EngineKind engine : {EngineKind::Blocks, EngineKind::Hash, EngineKind::Ode}) {
        auto scene = make_scene({.engine = engine, .gravity_m_s2 = {}, .linear_damping_per_s = 0.5, .angular_damping_per_s = 1});
        need(scene->add_body({.id = 0, .linear_velocity_m_s = {1, 0, 0}, .angular_velocity_rad_s = {0, 0, 2}}));
        run(*scene, 240, 1, workers_);
        EXPECT_NEAR(speed(*scene, 0), std::exp(-0.5), 1e-3);
        EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, 2 * std::exp(-1.0), 4e-3);
    }
}

TEST_F(Mechanics, PushesAndTorquesAccelerate) {
    auto scene = make_scene({.gravity_m_s2 = {}});
    need(scene->add_body({.id = 0, .radius_m = 0.5, .mass_kg = 2}));
    need(scene->set_wrench(0, {3, 0, 0}, {0, 0.1, 0}));
    run(*scene, 240, 1, workers_);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 1.5, 1e-4);
    EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.y, 0.1 / (0.4 * 2 * 0.25), 1e-4);
    need(scene->set_wrench(0, {}, {}));
    run(*scene, 60, 1, workers_);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 1.5, 1e-4);
}

TEST_F(Mechanics, SpinTurnsTheBody) {
    auto scene = make_scene({.gravity_m_s2 = {}});
    need(scene->add_body({.id = 0, .angular_velocity_rad_s = {0, 0, std::numbers::pi / 2}}));
    run(*scene, 240, 1, workers_);
    const Vec3 x = rotate(scene->state(0).orientation, {1, 0, 0});
    EXPECT_NEAR(x.x, 0, 1e-3);
    EXPECT_NEAR(x.y, 1, 1e-3);
}

// A ball thrown flat slides with the friction's deceleration until it rolls, at 5/7 of its speed.
TEST_F(Mechanics, SlidingBecomesRollingAtFiveSevenths) {
    auto scene = scene_on_plane();
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .linear_velocity_m_s = {7, 0, 0}}));
    run(*scene, 24, 2, workers_);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 7 - 0.5 * kGravity * 0.1, 0.02);
    run(*scene, 240, 2, workers_);
    const BodyState state = scene->state(0);
    EXPECT_NEAR(state.linear_velocity_m_s.x, 5, 0.01);
    EXPECT_NEAR(state.angular_velocity_rad_s.y * 0.5, state.linear_velocity_m_s.x, 1e-3);
    EXPECT_NEAR(state.linear_velocity_m_s.y, 0, 1e-6);
}

// On a slope: rolling without slipping gains 5/7 of the slope's pull, and with little friction it slides.
TEST_F(Mechanics, RollingAndSlidingDownASlope) {
    const double angle = 0.3;
    for (const double friction : {0.5, 0.02}) {
        auto scene = make_scene({.gravity_m_s2 = {kGravity * std::sin(angle), 0, -kGravity * std::cos(angle)}});
        const auto material = need(scene->add_material({.friction = static_cast<float>(friction)}));
        need(scene->add_obstacle(Plane{}, material));
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .material = material}));
        run(*scene, 240, 2, workers_);
        const double rolling = 5.0 / 7 * kGravity * std::sin(angle), sliding = kGravity * (std::sin(angle) - friction * std::cos(angle));
        EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, friction > 0.1 ? rolling : sliding, 0.01) << friction;
    }
}

TEST_F(Mechanics, HollowBallsRollMoreSlowly) {
    const double angle = 0.3;
    auto scene = make_scene({.gravity_m_s2 = {kGravity * std::sin(angle), 0, -kGravity * std::cos(angle)}});
    need(scene->add_obstacle(Plane{}, 0));
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .inertia_factor = 2.0 / 3}));
    run(*scene, 240, 2, workers_);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 3.0 / 5 * kGravity * std::sin(angle), 0.01);
}

// In both modes, with any number of substeps: it is pressed with its weight, and slows by friction alone, mu g.
TEST_F(Mechanics, WeightAndFrictionDoNotDependOnSubsteps) {
    for (const SolverMode mode : {SolverMode::Soft, SolverMode::Pgs})
        for (const int substeps : {1, 2, 5}) {
            SolverSettings solver = SolverSettings::pgs20();
            if (mode == SolverMode::Soft) solver = {};
            auto scene = scene_on_plane({.solver = solver, .sleep_ticks = 0});
            need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .linear_velocity_m_s = {4, 0, 0}, .inertia_factor = 1}));
            run(*scene, 60, substeps, workers_);
            // mu = 0.5; slipping ends when v = 4 / (1 + inertia factor), after the quarter of a second.
            EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 4 - 0.5 * kGravity * 0.25, 0.03) << substeps;
            run(*scene, 120, substeps, workers_);
            ASSERT_EQ(scene->contacts().size(), 1u);
            EXPECT_NEAR(scene->contacts()[0].normal_force_n, kGravity, 0.02 * kGravity) << substeps;
        }
}

TEST_F(Mechanics, BallsBounceBackWithTheirRestitution) {
    for (const double restitution : {0.0, 0.5, 0.9}) {
        auto scene = make_scene();
        const auto material = need(scene->add_material({.friction = 0.5f, .restitution = static_cast<float>(restitution)}));
        need(scene->add_obstacle(Plane{}, material));
        need(scene->add_body({.id = 0, .position_m = {0, 0, 2.5}, .material = material}));
        double highest = 0;
        bool fell = false;
        for (int tick = 0; tick < 400; ++tick) {
            run(*scene, 1, 4, workers_);
            const BodyState state = scene->state(0);
            fell = fell || state.position_m.z < 0.52;
            if (fell) highest = std::max(highest, state.position_m.z - 0.5);
        }
        // Dropped from 2 m above touching; a tick's motion is the error.
        EXPECT_NEAR(highest, 2 * restitution * restitution, 0.06) << restitution;
    }
}

TEST_F(Mechanics, EqualBallsExchangeVelocities) {
    auto scene = make_scene({.gravity_m_s2 = {}});
    const auto material = need(scene->add_material({.friction = 0.0f, .restitution = 1.0f}));
    need(scene->add_body({.id = 0, .position_m = {-2, 0, 0}, .linear_velocity_m_s = {3, 0, 0}, .material = material}));
    need(scene->add_body({.id = 1, .position_m = {0, 0, 0}, .material = material}));
    run(*scene, 240, 1, workers_);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 0, 1e-4);
    EXPECT_NEAR(scene->state(1).linear_velocity_m_s.x, 3, 1e-4);
}

// Soft contacts are the default, which these have not.
TEST_F(Mechanics, OtherEnginesExchangeVelocitiesUnlessToldOtherwise) {
    for (const EngineKind engine : {EngineKind::Hash, EngineKind::Ode}) {
        auto scene = make_scene({.engine = engine, .gravity_m_s2 = {}});
        const std::uint8_t elastic = need(scene->add_material({.restitution = 1}));
        need(scene->add_body({.id = 0, .linear_velocity_m_s = {1, 0, 0}, .material = elastic}));
        need(scene->add_body({.id = 1, .position_m = {1.5, 0, 0}, .material = elastic}));
        run(*scene, 240, 2, workers_);
        EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 0, 1e-3);
        EXPECT_NEAR(scene->state(1).linear_velocity_m_s.x, 1, 1e-3);
    }
}

TEST_F(Mechanics, HeavyBallsPushLightOnes) {
    auto scene = make_scene({.gravity_m_s2 = {}});
    const auto material = need(scene->add_material({.friction = 0.0f, .restitution = 1.0f}));
    need(scene->add_body(
        {.id = 0, .position_m = {-2, 0, 0}, .linear_velocity_m_s = {1, 0, 0}, .radius_m = 0.5, .mass_kg = 3, .material = material}));
    need(scene->add_body({.id = 1, .position_m = {0, 0, 0}, .radius_m = 0.2, .mass_kg = 1, .material = material}));
    run(*scene, 480, 1, workers_);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 0.5, 1e-4);
    EXPECT_NEAR(scene->state(1).linear_velocity_m_s.x, 1.5, 1e-4);
}

// A touching cube of balls stands: the pile sags by a fraction of a percent and stops moving.
TEST_F(Mechanics, TouchingStackStands) {
    auto scene = scene_on_plane({.sleep_ticks = 0});
    const int side = 8;
    add_cube(*scene, side);
    run(*scene, 240, 2, workers_);
    const double v_rms = std::sqrt(2 * scene->kinetic_energy_j() / (side * side * side));
    EXPECT_LT(v_rms, 1e-3);
    for (BodyId id = 0; id < side * side * side; ++id) {
        const Vec3 p = scene->state(id).position_m;
        EXPECT_NEAR(p.x, id % side, 2e-3);
        EXPECT_NEAR(p.y, id / side % side, 2e-3);
        EXPECT_LT(p.z, id / (side * side) + 0.5 + 1e-4);
        EXPECT_GT(p.z, id / (side * side) + 0.5 - 4e-3);
    }
}

// Momentum is exchanged, never made; energy is lost, never won.
TEST_F(Mechanics, CloudKeepsMomentumAndGainsNoEnergy) {
    auto scene = make_scene({.gravity_m_s2 = {}, .sleep_ticks = 0});
    add_cloud(*scene, 7, 1.05, 17, 0);
    const Vec3 momentum = scene->momentum(), spin = scene->angular_momentum();
    double energy = scene->kinetic_energy_j();
    const double mass_speed = std::sqrt(energy * 343);
    std::size_t touches = 0;
    for (int tick = 0; tick < 240; ++tick) {
        run(*scene, 1, 2, workers_);
        touches += scene->events().size();
        EXPECT_LE(scene->kinetic_energy_j(), energy * 1.01) << tick;
        energy = scene->kinetic_energy_j();
    }
    EXPECT_GT(touches, 300u);
    EXPECT_LT(length(scene->momentum() - momentum), 1e-5 * mass_speed);
    // Friction acts at the middle of an overlap, levers end at the surfaces: the difference is of the size of overlaps.
    EXPECT_LT(length(scene->angular_momentum() - spin), 2e-2 * mass_speed);
}

TEST_F(Mechanics, FixedBodiesCarryAndDoNotMove) {
    auto scene = make_scene();
    for (BodyId x = 0; x < 5; ++x)
        for (BodyId y = 0; y < 5; ++y) need(scene->add_body({.id = 5 * y + x, .position_m = {double(x), double(y), 0}, .fixed = true}));
    need(scene->add_body({.id = 100, .position_m = {1.5, 1.5, 1.5}}));
    run(*scene, 480, 2, workers_);
    EXPECT_EQ(scene->state(7).position_m, (Vec3{2, 1, 0}));
    // It rests in the hollow between four.
    EXPECT_NEAR(scene->state(100).position_m.z, std::sqrt(0.5), 5e-3);
    EXPECT_LT(speed(*scene, 100), 1e-2);
}

TEST_F(Mechanics, SmallBallsRestOnLargeOnes) {
    auto scene = scene_on_plane();
    need(scene->add_body({.id = 0, .position_m = {0, 0, 1}, .radius_m = 1, .mass_kg = 8, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {0, 0, 2.25}, .radius_m = 0.25, .mass_kg = 0.125}));
    run(*scene, 60, 2, workers_);
    EXPECT_NEAR(scene->state(1).position_m.z, 2.25, 5e-3);
    EXPECT_EQ(scene->contacts().size(), 1u);
}

}  // namespace
}  // namespace meld::physics
