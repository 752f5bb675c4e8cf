// Magnets and plates on boxes, cylinders and capsules.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "physics/bodies/actuation.h"
#include "physics/collision/core_contacts.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics::shape_features {
namespace {

const std::vector<BodyShape> kSome = {box_shape({1, 0.8, 0.4}, 0.02), box_shape({0.7, 0.5, 0.9}, 0), cylinder_shape(0.4, 0.6, 0.05),
                                      cylinder_shape(0.3, 1, 0),      capsule_shape(0.25, 1.2),      box_shape({1, 1, 1}, 0.3)};

double from_core(const BodyShape& shape, Vec3 p) {
    const auto beyond = [](double at, double half) { return std::max(0.0, std::abs(at) - half); };
    if (shape.core_m.y > 0) return length({beyond(p.x, shape.core_m.x), beyond(p.y, shape.core_m.y), beyond(p.z, shape.core_m.z)});
    return std::hypot(beyond(std::hypot(p.x, p.y), shape.core_m.x), beyond(p.z, shape.core_m.z));
}

TEST(ShapeFeatures, AreOnTheSurface) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    for (const BodyShape& shape : kSome) {
        for (int trial = 0; trial < 1000; ++trial) {
            Vec3 direction{normal(random), trial % 7 == 0 ? 0 : normal(random), trial % 5 == 0 ? 0 : normal(random)};
            direction = (1 / length(direction)) * direction;
            const double way = shape.way_out_m(direction);
            EXPECT_NEAR(from_core(shape, way * direction), shape.rounding_m, 1e-12) << trial;
            EXPECT_GT(from_core(shape, (way + 1e-6) * direction), shape.rounding_m) << trial;
        }
    }
    EXPECT_NEAR(box_shape({1, 0.8, 0.4}, 0).way_out_m({0, 0.6, 0.8}), 0.25, 1e-14);
    EXPECT_NEAR(cylinder_shape(0.4, 0.6, 0.05).way_out_m({0.6, 0.8, 0}), 0.4, 1e-14);
    EXPECT_NEAR(capsule_shape(0.25, 1.2).way_out_m({0, 0, -1}), 0.6, 1e-14);
}

class ShapeMagnets : public testing::TestWithParam<EngineKind> {
  protected:
    static std::unique_ptr<Scene> scene_with(Settings settings = {}) {
        settings.engine = GetParam();
        if (GetParam() != EngineKind::Blocks) settings.solver = SolverSettings::pgs20();
        return make_scene(settings);
    }
    Workers workers_{1};
};

// A magnet beside the middle of a face pulls and turns, as the formula says at its place.
TEST_P(ShapeMagnets, PullWhereTheyAre) {
    for (const FeatureKind kind : {FeatureKind::Dipole, FeatureKind::TwoPole, FeatureKind::Plate}) {
        auto scene = scene_with({.gravity_m_s2 = {}, .sleep_ticks = 0});
        const double strength = kind == FeatureKind::Plate ? 5e4 : 300;
        const Feature one{.direction = {2, 0.6, 0}, .kind = kind, .strength = strength, .depth_m = 0.1, .range_m = 0.8};
        Feature other = one;
        other.direction = {-1, 0, 0.2};
        const auto first = need(scene->add_feature_table({one})), second = need(scene->add_feature_table({other}));
        const BodyShape cube = box_shape({1, 1, 1}, 0), can = cylinder_shape(0.5, 1, 0);
        const Quat turn = turn_of(0.1, {0, 0, 1});
        need(scene->add_body({.id = 0, .mass_kg = 2, .shape = cube}));
        need(scene->add_body({.id = 1, .position_m = {1.25, 0.1, 0.05}, .orientation = turn, .mass_kg = 3, .shape = can}));
        need(scene->set_feature_table(0, first));
        need(scene->set_feature_table(1, second));
        need(scene->set_features(0, 1, 0));
        need(scene->set_features(1, 1, 1));
        const double dt = 1e-3;
        need(scene->step(dt, 1, workers_));

        const auto unit = [](Vec3 v) { return (1 / length(v)) * v; };
        const Vec3 on_cube{0.5, 0.15, 0}, on_can{-0.5, 0, 0.1};
        const auto turned = [&](Vec3 v) { return rotate(turn, v); };
        double charge = 0;
        const Interaction wanted =
            interact(one, {on_cube, unit(on_cube), 1}, other, {Vec3{1.25, 0.1, 0.05} + turned(on_can), turned(unit(on_can)), -1}, charge);
        ASSERT_GT(length(wanted.force_n), 1e-3);
        const BodyState a = scene->state(0), b = scene->state(1);
        const double scale = dt * length(wanted.force_n);
        EXPECT_LT(length(2 * a.linear_velocity_m_s + dt * wanted.force_n), 1e-5 * scale);
        EXPECT_LT(length(3 * b.linear_velocity_m_s - dt * wanted.force_n), 1e-5 * scale);
        const Vec3 torque = wanted.first_torque_nm - cross(on_cube, wanted.force_n);
        EXPECT_LT(length((2.0 / 6) * a.angular_velocity_rad_s - dt * torque), 1e-5 * scale);
        const Vec3 on_b = wanted.second_torque_nm + cross(turned(on_can), wanted.force_n);
        EXPECT_NEAR(3 * 0.125 * b.angular_velocity_rad_s.z, dt * on_b.z, 1e-5 * scale);
        if (kind == FeatureKind::Plate) {
            EXPECT_NEAR(scene->energy_drawn_j(0), charge / 2, 1e-5 * charge);
        }
    }
}

// What they gain in speed the field loses; momentum and angular momentum stay.
TEST_P(ShapeMagnets, KeepEnergyAndMomentum) {
    auto scene = scene_with({.gravity_m_s2 = {}, .sleep_ticks = 0});
    const Feature magnet{.direction = {1, 0.2, 0.1}, .strength = 300, .depth_m = 0.2, .range_m = 1.2};
    const auto table = need(scene->add_feature_table({magnet}));
    const BodyShape brick = box_shape({1, 0.8, 0.6}, 0.02);
    need(scene->add_body({.id = 0, .shape = brick}));
    need(scene->add_body({.id = 1, .position_m = {1.5, 0.1, 0}, .orientation = turn_of(3, {0, 0.2, 1}), .shape = brick}));
    for (const BodyId id : {0u, 1u}) need(scene->set_feature_table(id, table)), need(scene->set_features(id, 1, 0));
    const double way = brick.way_out_m((1 / length(magnet.direction)) * magnet.direction);
    const auto pose = [&](BodyId id) {
        const BodyState state = scene->state(id);
        const auto axes = pose_of({}, state.orientation).axes;
        const Vec3 d = (1 / length(magnet.direction)) * (1.0 * axes[0] + 0.2 * axes[1] + 0.1 * axes[2]);
        return FeaturePose{state.position_m + way * d, d, 1};
    };
    const auto energy = [&] {
        double charge = 0;
        return scene->kinetic_energy_j() + interact(magnet, pose(0), magnet, pose(1), charge).energy_j;
    };
    const auto spin = [&](BodyId id) {
        const BodyState state = scene->state(id);
        const auto axes = pose_of({}, state.orientation).axes;
        const Vec3 inertia = brick.inertia_per_kg_m2(), w = state.angular_velocity_rad_s;
        return cross(state.position_m, state.linear_velocity_m_s) + inertia.x * dot(w, axes[0]) * axes[0] +
               inertia.y * dot(w, axes[1]) * axes[1] + inertia.z * dot(w, axes[2]) * axes[2];
    };
    const double before = energy();
    ASSERT_GT(std::abs(before), 1e-3);
    double moved = 0;
    for (int tick = 0; tick < 400; ++tick) {
        need(scene->step(1.0 / 480, 2, workers_));
        moved = std::max(moved, scene->kinetic_energy_j());
        EXPECT_NEAR(energy(), before, 0.03 * moved + 1e-4 * std::abs(before)) << tick;
    }
    EXPECT_GT(moved, 0.1 * std::abs(before));
    EXPECT_LT(length(scene->momentum()), 1e-5);
    EXPECT_LT(length(spin(0) + spin(1)), 0.01 * length(spin(0)));
}

// Planar catoms: cylinders of 44 mm with 24 magnets around the rim, on a smooth table. The next pair of magnets is on, then the one after.
TEST_P(ShapeMagnets, SwitchingRollsOneCylinderAroundAnother) {
    auto scene = scene_with({.linear_damping_per_s = 10, .angular_damping_per_s = 10, .sleep_ticks = 0});
    const auto rough = need(scene->add_material({.friction = 1})), smooth = need(scene->add_material({.friction = 0}));
    need(scene->add_obstacle(Plane{}, smooth));
    constexpr int kCount = 24;
    std::vector<Feature> ring;
    for (int i = 0; i < kCount; ++i) {
        const double angle = 2 * std::numbers::pi * i / kCount;
        ring.push_back({.direction = {std::cos(angle), std::sin(angle), 0}, .strength = 0.08, .depth_m = 0.003, .range_m = 0.012});
    }
    const auto table = need(scene->add_feature_table(ring));
    const BodyShape can = cylinder_shape(0.022, 0.03, 0.0005);
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0.015}, .mass_kg = 0.1, .material = rough, .fixed = true, .shape = can}));
    need(scene->add_body({.id = 1, .position_m = {0.044, 0, 0.015}, .mass_kg = 0.1, .material = rough, .shape = can}));
    for (const BodyId id : {0u, 1u}) need(scene->set_feature_table(id, table));
    for (int step = 0; step <= 6; ++step) {
        const int fixed = step, rolling = (kCount / 2 - step + kCount) % kCount;
        need(scene->set_features(0, 1u << fixed, 0));
        need(scene->set_features(1, 1u << rolling, 1u << rolling));
        for (int tick = 0; tick < 500; ++tick) need(scene->step(1.0 / 1200, 2, workers_));
        const BodyState state = scene->state(1);
        EXPECT_NEAR(std::atan2(state.position_m.y, state.position_m.x), step * std::numbers::pi / 12, 0.03) << step;
        EXPECT_NEAR(std::hypot(state.position_m.x, state.position_m.y), 0.044, 2e-4);
        EXPECT_NEAR(state.position_m.z, 0.015, 1e-4);
        // It turns twice as far as it gets around.
        const double turned = 2 * std::atan2(state.orientation.z, state.orientation.w);
        EXPECT_NEAR(turned, step * std::numbers::pi / 6, 0.06) << step;
    }
}

INSTANTIATE_TEST_SUITE_P(Engines, ShapeMagnets, testing::Values(EngineKind::Blocks, EngineKind::Ode),
                         [](const auto& engine) { return engine.param == EngineKind::Blocks ? "Blocks" : "Ode"; });

TEST(ShapeFeatures, SameBitsForAnyNumberOfWorkersAndAfterASnapshot) {
    const auto empty = [] {
        auto scene = scene_on_plane();
        std::vector<Feature> features;
        for (const Vec3 direction : feature_directions(6)) features.push_back({.direction = direction, .strength = 200, .depth_m = 0.1});
        need(scene->add_feature_table(features));
        return scene;
    };
    expect_same_bits(empty, [](Scene& scene) {
        for (BodyId id = 0; id < 64; ++id) {
            BodySpec spec{.id = id, .position_m = {1.15 * (id % 4), 1.15 * (id / 4 % 4), 0.6 + 1.15 * (id / 16)}};
            if (id % 7 != 6) spec.shape = kSome[id % 6];
            need(scene.add_body(spec));
            need(scene.set_feature_table(id, 1));
            need(scene.set_features(id, 0b111111, id % 3 == 0 ? 0b111111 : 0b001010));
        }
    });
}

}  // namespace
}  // namespace meld::physics::shape_features
