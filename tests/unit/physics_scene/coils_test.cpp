// Electromagnets: strength by current up to saturation, heat, what a coil that is too hot does; and plates at other voltages.
#include "physics/bodies/coils.h"

#include <gtest/gtest.h>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

Feature coil(Vec3 direction = {1, 0, 0}) {
    return {.direction = direction,
            .strength = 10,
            .depth_m = 0.05,
            .range_m = 0.5,
            .current_a = 2,
            .resistance_ohm = 1.5,
            .thermal_resistance_k_w = 8,
            .cooling_s = 1.25};
}

class Coiled : public testing::TestWithParam<EngineKind> {
  protected:
    // One body or two, fixed or free, with this feature towards each other, switched on.
    std::unique_ptr<Scene> scene_with(const Feature& feature, int bodies) const {
        auto scene = make_scene({.engine = GetParam(), .gravity_m_s2 = {}});
        Feature other = feature;
        other.direction = -feature.direction;
        const auto table = need(scene->add_feature_table({feature, other}));
        for (BodyId id = 0; id < static_cast<BodyId>(bodies); ++id) {
            need(scene->add_body({.id = id, .position_m = {1.2 * id, 0, 0}}));
            need(scene->set_feature_table(id, table));
            need(scene->set_features(id, 1u << id, id == 1 ? 0b10 : 0));
        }
        return scene;
    }
    Workers workers_{1};
};

TEST(Coils, FollowFroehlichAndKennelly) {
    Feature iron = coil();
    EXPECT_EQ(strength_at(iron, 3), 15);
    iron.saturation = 20;
    // Half of the saturation where the coil alone would have all of it.
    EXPECT_DOUBLE_EQ(strength_at(iron, 4), 10);
    EXPECT_NEAR(strength_at(iron, 1e-3) / strength_at(coil(), 1e-3), 1, 3e-4);
    EXPECT_NEAR(strength_at(iron, 1e6), 20, 1e-4);
    // So the force between two goes with the square of the current at first, and hardly with it in the end.
    const auto force = [&](double current) { return strength_at(iron, current) * strength_at(iron, current); };
    EXPECT_NEAR(force(2e-3) / force(1e-3), 4, 0.002);
    EXPECT_NEAR(force(2e4) / force(1e4), 1, 0.001);
}

TEST_P(Coiled, PullsAsItsCurrentSays) {
    for (const double saturation : {0.0, 20.0})
        for (const double current : {0.5, 2.0, 8.0}) {
            Feature feature = coil();
            feature.saturation = saturation;
            auto scene = scene_with(feature, 2);
            for (const BodyId id : {0u, 1u}) need(scene->set_supply(id, id, current));
            need(scene->step(1e-3, 1, workers_));
            const double m = strength_at(feature, current), gap = 0.2, x = std::pow((gap + 0.1) / (0.5 + 0.1), 3);
            // What dipoles() says on an axis, as it ends at the range.
            const double force = -dipoles({m, 0, 0}, {m, 0, 0}, {gap + 0.1, 0, 0}).force_n.x * (1 - x * x);
            EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x / (force * 1e-3), 1, 1e-4) << current << " A, " << saturation;
        }
}

TEST_P(Coiled, WarmsAndCoolsAsTheClosedFormulaSays) {
    auto scene = scene_with(coil(), 1);
    need(scene->set_supply(0, 0, 3));
    const double watts = 9 * 1.5, end = 8 * watts, tau = 1.25;
    double seconds = 0;
    for (const int ticks : {1, 60, 240, 600}) {
        for (int i = 0; i < ticks; ++i) need(scene->step(kTick, 1, workers_));
        seconds += ticks * kTick;
        EXPECT_NEAR((scene->temperature_k(0, 0) - 293.15) / (end * (1 - std::exp(-seconds / tau))), 1, 1e-6) << seconds;
        EXPECT_NEAR(scene->energy_drawn_j(0) / (watts * seconds), 1, 1e-9);
    }
    EXPECT_EQ(scene->temperature_k(0, 1), 293.15);
    need(scene->set_features(0, 0, 0));
    const double warm = scene->temperature_k(0, 0) - 293.15;
    for (int i = 0; i < 480; ++i) need(scene->step(kTick, 1, workers_));
    EXPECT_NEAR((scene->temperature_k(0, 0) - 293.15) / (warm * std::exp(-2 / tau)), 1, 1e-6);
    EXPECT_TRUE(scene->warming(1));
    EXPECT_FALSE(scene->warming(100));
    // Switched on again, it has its rated current.
    need(scene->set_features(0, 1, 0));
    const double before = scene->energy_drawn_j(0);
    need(scene->step(kTick, 1, workers_));
    EXPECT_NEAR((scene->energy_drawn_j(0) - before) / (4 * 1.5 * kTick), 1, 1e-6);
}

TEST_P(Coiled, IsSwitchedOffWhereItGetsTooHot) {
    Feature feature = coil();
    feature.hottest_k = 293.15 + 30;
    auto scene = scene_with(feature, 1);
    // 48 K in the end, 30 K after tau ln(48 / 18).
    const double after = 1.25 * std::log(48.0 / 18);
    int ticks = 0;
    for (; ticks < 1000 && scene->features(0).on == 1; ++ticks) need(scene->step(kTick, 1, workers_));
    EXPECT_NEAR(ticks * kTick, after, 2.1 * kTick);
    const double cooler = scene->temperature_k(0, 0);
    for (int i = 0; i < 100; ++i) need(scene->step(kTick, 1, workers_));
    EXPECT_LT(scene->temperature_k(0, 0), cooler - 5);
    EXPECT_EQ(scene->features(0).on, 0u);
}

TEST_P(Coiled, GetsLessWhereItIsDerated) {
    Feature feature = coil();
    feature.hottest_k = 293.15 + 30, feature.derating_per_k = 0.02;
    auto scene = scene_with(feature, 1);
    for (int i = 0; i < 5000; ++i) need(scene->step(kTick, 1, workers_));
    // 48 K times the square of what is left of the current.
    const double rise = scene->temperature_k(0, 0) - 293.15, left = 1 - 0.02 * (rise - 30);
    EXPECT_NEAR(rise / (48 * left * left), 1, 1e-3);
    EXPECT_LT(rise, 45);
    EXPECT_EQ(scene->features(0).on, 1u);
    EXPECT_FALSE(scene->warming(0.1));
}

TEST_P(Coiled, RefusesWhatIsNoCurrent) {
    auto scene = scene_with(coil(), 1);
    EXPECT_FALSE(scene->set_supply(0, 2, 1));
    EXPECT_FALSE(scene->set_supply(0, 0, -1));
    EXPECT_FALSE(scene->set_supply(7, 0, 1));
    EXPECT_FALSE(scene->add_feature_table({{.kind = FeatureKind::Latch, .current_a = 1}}));
    Feature at_once = coil();
    at_once.cooling_s = 0;
    EXPECT_FALSE(scene->add_feature_table({at_once}));
}

TEST_P(Coiled, PlatesPullWithTheSquareOfTheirVoltage) {
    const auto speed = [&](double volts) {
        auto scene = scene_with({.direction = {1, 0, 0}, .kind = FeatureKind::Plate, .strength = 1000, .area_m2 = 0.05, .range_m = 1}, 2);
        for (const BodyId id : {0u, 1u}) need(scene->set_supply(id, id, volts));
        need(scene->step(1e-3, 1, workers_));
        return scene->state(0).linear_velocity_m_s.x;
    };
    EXPECT_GT(speed(500), 0);
    EXPECT_NEAR(speed(1000) / speed(500), 4, 1e-4);
    EXPECT_NEAR(speed(3000) / speed(500), 36, 1e-3);
}

// A ball that hangs on the coil of another and sleeps falls once that is too hot.
TEST(Coils, WakeWhatHangsOnThem) {
    auto scene = make_scene();
    Feature up = coil({0, 0, 1}), down = coil({0, 0, -1});
    up.strength = down.strength = 60, up.range_m = down.range_m = 0.05;
    // The lower one is no coil. 48 K in the end; 47 K after 4.8 s.
    up.current_a = up.resistance_ohm = up.thermal_resistance_k_w = up.cooling_s = 0;
    down.hottest_k = 293.15 + 47;
    const auto table = need(scene->add_feature_table({up, down}));
    need(scene->add_body({.id = 0, .position_m = {0, 0, 3}, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {0, 0, 2}}));
    for (const BodyId id : {0u, 1u}) need(scene->set_feature_table(id, table));
    need(scene->set_features(0, 2, 0));
    need(scene->set_features(1, 1, 1));
    Workers workers(2);
    bool slept = false;
    int ticks = 0;
    for (; ticks < 2400 && scene->features(0).on != 0; ++ticks) {
        need(scene->step(kTick, 2, workers));
        slept = slept || scene->asleep(1);
        ASSERT_GT(scene->state(1).position_m.z, 1.95) << ticks;
    }
    EXPECT_TRUE(slept);
    EXPECT_NEAR(ticks * kTick, 1.25 * std::log(48.0), 0.02);
    for (int i = 0; i < 120; ++i) need(scene->step(kTick, 2, workers));
    EXPECT_LT(scene->state(1).position_m.z, 1);
}

INSTANTIATE_TEST_SUITE_P(Engines, Coiled, testing::Values(EngineKind::Blocks, EngineKind::Hash, EngineKind::Ode), [](const auto& engine) {
    return engine.param == EngineKind::Blocks ? "Blocks" : engine.param == EngineKind::Hash ? "Hash" : "Ode";
});

}  // namespace
}  // namespace meld::physics
