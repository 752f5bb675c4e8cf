// Small scenes through our solver and through ODE, side by side over time.
#include <gtest/gtest.h>

#include "tests/unit/physics/two_engines.h"

namespace meld::physics {
namespace {

struct Pair : BothEngines {
    explicit Pair(SolverSettings solver, Vec3 gravity = {0, 0, -9.81}) : BothEngines(kTick, gravity, solver) {}
    // The largest distance between a body in the two engines after N ticks.
    double apart_after(int ticks) {
        steps(ticks);
        return apart_now();
    }
};

class AgainstOde : public testing::TestWithParam<SolverMode> {
  protected:
    static SolverSettings solver() { return GetParam() == SolverMode::Soft ? SolverSettings{} : SolverSettings::pgs20(); }
};

TEST_P(AgainstOde, FreeFlightIsTheSame) {
    Pair pair(solver());
    pair.each(
        [](Scene& scene) { need(scene.add_body({.id = 0, .linear_velocity_m_s = {3, 1, 10}, .angular_velocity_rad_s = {1, 2, 3}})); });
    EXPECT_LT(pair.apart_after(240), 1e-4);
    EXPECT_LT(length(pair.ours->state(0).angular_velocity_rad_s - pair.odes->state(0).angular_velocity_rad_s), 1e-5);
}

TEST_P(AgainstOde, SlidingAndRollingGoTheSameWay) {
    Pair pair(solver());
    pair.each([](Scene& scene) {
        need(scene.add_obstacle(Plane{}, 0));
        need(scene.add_body({.id = 0, .position_m = {0, 0, 0.5}, .linear_velocity_m_s = {5, 2, 0}, .angular_velocity_rad_s = {0, 0, 4}}));
    });
    // ODE takes a tick to notice the contact, for it must overlap first, and its friction is a pyramid along the axes: it has
    // less friction along a diagonal's axes. Over 7 m of way they part by this much.
    EXPECT_LT(pair.apart_after(60), 0.1);
    EXPECT_LT(pair.apart_after(180), 0.5);
    EXPECT_LT(length(pair.ours->state(0).linear_velocity_m_s - pair.odes->state(0).linear_velocity_m_s), 0.25);
}

TEST_P(AgainstOde, DroppedBallsComeToRestAlike) {
    Pair pair(solver());
    pair.each([](Scene& scene) {
        need(scene.add_obstacle(Plane{}, 0));
        for (BodyId id = 0; id < 9; ++id) need(scene.add_body({.id = id, .position_m = {1.5 * (id % 3), 1.5 * (id / 3), 1 + 0.1 * id}}));
    });
    EXPECT_LT(pair.apart_after(60), 0.03);
    EXPECT_LT(pair.apart_after(240), 0.01);
}

TEST_P(AgainstOde, CollisionOfTwoBallsPartsThemAlike) {
    Pair pair(solver(), {});
    pair.each([](Scene& scene) {
        need(scene.add_body({.id = 0, .position_m = {-1, 0.3, 0}, .linear_velocity_m_s = {2, 0, 0}, .mass_kg = 2}));
        need(scene.add_body({.id = 1, .position_m = {0.5, 0, 0}}));
    });
    EXPECT_LT(pair.apart_after(120), 0.08);
    for (const BodyId id : {0u, 1u})
        EXPECT_LT(length(pair.ours->state(id).linear_velocity_m_s - pair.odes->state(id).linear_velocity_m_s), 0.15);
}

// A pyramid of 14 balls with a fixed base stands in both.
TEST_P(AgainstOde, PyramidStandsAlike) {
    Pair pair(solver());
    pair.each([](Scene& scene) {
        BodyId id = 0;
        const double up = std::sqrt(0.5);
        for (int layer = 0; layer < 3; ++layer)
            for (int x = 0; x < 3 - layer; ++x)
                for (int y = 0; y < 3 - layer; ++y)
                    need(scene.add_body({.id = id++, .position_m = {x + 0.5 * layer, y + 0.5 * layer, up * layer}, .fixed = layer == 0}));
    });
    EXPECT_LT(pair.apart_after(240), 0.03);
}

// While a pile's first layers compact, both lose the same height and energy, within a few percent of the fall.
TEST_P(AgainstOde, FallingLayersLoseTheSameHeight) {
    Pair pair(solver());
    pair.each([](Scene& scene) {
        need(scene.add_obstacle(Plane{}, 0));
        add_cube(scene, 4, 1.05, {0, 0, 0.8});
    });
    for (int second = 0; second < 3; ++second) {
        pair.apart_after(30);
        const double ours = pair.ours->potential_energy_j(), odes = pair.odes->potential_energy_j();
        EXPECT_NEAR(ours, odes, 0.03 * odes) << second;
    }
}

INSTANTIATE_TEST_SUITE_P(Modes, AgainstOde, testing::Values(SolverMode::Pgs, SolverMode::Soft),
                         [](const auto& test) { return test.param == SolverMode::Pgs ? "Pgs" : "Soft"; });

}  // namespace
}  // namespace meld::physics
