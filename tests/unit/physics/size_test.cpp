// What follows the size of bodies: scenes of half a millimetre and of ten metres do the same, in steps that follow the size too.
#include <gtest/gtest.h>

#include "runtime/base/default_time_scale.h"
#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

constexpr double kDiameters_m[] = {0.001, 0.01, 1, 10};

class Sizes : public testing::Test {
  protected:
    static void step(Scene& scene, int ticks, double dt_s, Workers& workers) {
        for (int tick = 0; tick < ticks; ++tick) {
            const auto report = scene.step(dt_s, 2, workers);
            ASSERT_TRUE(report) << report.error().message();
        }
    }
    Workers workers_{1};
};

TEST_F(Sizes, ColumnsAreHardlySquashed) {
    for (const double d : kDiameters_m) {
        auto scene = scene_on_plane({.sleep_ticks = 0});
        const int high = 10;
        for (int i = 0; i < high; ++i)
            need(scene->add_body(
                {.id = static_cast<BodyId>(i), .position_m = {0, 0, (i + 0.5) * d}, .radius_m = d / 2, .mass_kg = d * d * d}));
        step(*scene, 240, natural_step_s(d, kGravity), workers_);
        const double height = scene->state(high - 1).position_m.z + d / 2;
        EXPECT_NEAR(height / (high * d), 1, 1e-3) << d;
        EXPECT_LT(height, high * d) << d;
    }
}

TEST_F(Sizes, BouncesReachTheirHeights) {
    for (const double d : kDiameters_m) {
        auto scene = make_scene({.sleep_ticks = 0});
        const auto material = need(scene->add_material({.restitution = 0.8f}));
        need(scene->add_obstacle(Plane{}, material));
        need(scene->add_body({.id = 0, .position_m = {0, 0, 2.5 * d}, .radius_m = d / 2, .mass_kg = d * d * d, .material = material}));
        double down = 0, up = 0;
        for (int tick = 0; tick < 240 && up == 0; ++tick) {
            const double before = scene->state(0).linear_velocity_m_s.z;
            step(*scene, 1, natural_step_s(d, kGravity), workers_);
            const double after = scene->state(0).linear_velocity_m_s.z;
            if (before < 0 && after > 0) down = -before, up = after;
        }
        // Within the step of the bounce it falls, too.
        EXPECT_NEAR(up / down, 0.8, 0.02) << d;
    }
}

// The same scene with all lengths d times, times sqrt(d) times and masses d^3 times as large moves in the same way.
TEST_F(Sizes, ScenesAreSimilar) {
    const auto heights = [&](double d) {
        auto scene = make_scene({.sleep_ticks = 0});
        const auto material = need(scene->add_material({.restitution = 0.5f}));
        need(scene->add_obstacle(Plane{}, material));
        for (BodyId id = 0; id < 27; ++id)
            need(scene->add_body({.id = id,
                                  .position_m = d * Vec3{1.01 * (id % 3) + 0.1 * (id / 9), 1.01 * (id / 3 % 3), 2 + 1.1 * (id / 9)},
                                  .radius_m = d / 2,
                                  .mass_kg = d * d * d,
                                  .material = material}));
        step(*scene, 120, natural_step_s(d, kGravity), workers_);
        std::vector<double> found;
        for (BodyId id = 0; id < 27; ++id) found.push_back(scene->state(id).position_m.z / d);
        return found;
    };
    const std::vector<double> of_a_metre = heights(1);
    for (const double d : kDiameters_m) {
        const std::vector<double> here = heights(d);
        for (std::size_t i = 0; i < here.size(); ++i) EXPECT_NEAR(here[i], of_a_metre[i], 0.02) << d << " m, body " << i;
    }
}

TEST_F(Sizes, WeakGravityDoesNotLengthenSteps) {
    EXPECT_EQ(natural_step_s(1, kGravity), 1.0 / 240);
    EXPECT_EQ(natural_step_s(1, 0), 1.0 / 240);
    EXPECT_EQ(natural_step_s(4, 1.6), 2.0 / 240);
    EXPECT_NEAR(natural_step_s(1, 4 * kGravity), 0.5 / 240, 1e-15);
}

// Without gravity nothing presses, and slow elastic hits are elastic too.
TEST_F(Sizes, SlowBallsBounceWithoutGravity) {
    for (const double d : kDiameters_m) {
        auto scene = make_scene({.gravity_m_s2 = {}, .sleep_ticks = 0});
        const auto elastic = need(scene->add_material({.friction = 0, .restitution = 1}));
        const double speed = 0.02 * d;
        need(scene->add_body({.id = 0,
                              .position_m = {-1.01 * d, 0, 0},
                              .linear_velocity_m_s = {speed, 0, 0},
                              .radius_m = d / 2,
                              .mass_kg = 1,
                              .material = elastic}));
        need(scene->add_body({.id = 1, .radius_m = d / 2, .mass_kg = 1, .material = elastic}));
        step(*scene, 480, 1.0 / 240, workers_);
        EXPECT_NEAR(scene->state(1).linear_velocity_m_s.x / speed, 1, 1e-3) << d;
        EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x / speed, 0, 1e-3) << d;
    }
}

// Bodies that start inside each other part, and what they gain in speed is next to nothing beside what an overlap of a contact's
// spring would give.
TEST_F(Sizes, OverlappingStartsPartWithoutSpeed) {
    for (const double d : {0.001, 1.0})
        for (const double spacing : {0.6, 0.8, 0.95}) {
            auto scene = make_scene({.gravity_m_s2 = {}, .sleep_ticks = 0});
            for (BodyId id = 0; id < 64; ++id)
                need(scene->add_body({.id = id,
                                      .position_m = spacing * d * Vec3{double(id % 4), double(id / 4 % 4), double(id / 16)},
                                      .radius_m = d / 2,
                                      .mass_kg = d * d * d}));
            step(*scene, 1920, natural_step_s(d, kGravity), workers_);
            double deepest = 0;
            for (BodyId a = 0; a < 64; ++a)
                for (BodyId b = 0; b < a; ++b)
                    deepest = std::max(deepest, d - length(scene->state(a).position_m - scene->state(b).position_m));
            EXPECT_LT(deepest, 0.01 * d) << spacing;
            const double speed = std::sqrt(2 * scene->kinetic_energy_j() / (64 * d * d * d));
            EXPECT_LT(speed, 0.05 * std::sqrt(kGravity * d)) << d << " m, spacing " << spacing;
        }
}

}  // namespace
}  // namespace meld::physics
