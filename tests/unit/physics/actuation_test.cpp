// Magnets, plates and latches: the formulas against limits known from books and against their own energies, then in scenes.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <numbers>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

constexpr double kMu0 = 1.25663706212e-6;
constexpr double kEpsilon0 = 8.8541878128e-12;

TEST(Magnets, DipolesOnAnAxisAttractAsTheFourthPower) {
    for (const double r : {0.1, 0.3, 1.0}) {
        const Interaction done = dipoles({0, 0, 2}, {0, 0, 3}, {0, 0, r});
        EXPECT_NEAR(done.force_n.z, -3 * kMu0 * 2 * 3 / (2 * std::numbers::pi * std::pow(r, 4)), 1e-12 / std::pow(r, 4));
        EXPECT_NEAR(done.energy_j, -kMu0 * 2 * 3 / (2 * std::numbers::pi * r * r * r), 1e-14 / std::pow(r, 3));
        EXPECT_EQ(length(done.second_torque_nm), 0);
    }
    // Side by side, equal ones part.
    EXPECT_GT(dipoles({0, 0, 1}, {0, 0, 1}, {0.5, 0, 0}).force_n.x, 0);
}

// Force = -gradient of the energy, and forces with torques leave the angular momentum alone.
void check_interaction(const std::function<Interaction(Vec3)>& at, Vec3 r, double lever) {
    const Interaction done = at(r);
    const double step = 1e-5;
    const auto slope = [&](Vec3 d) { return (at(r + step * d).energy_j - at(r - step * d).energy_j) / (2 * step); };
    const Vec3 gradient{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
    EXPECT_LT(length(done.force_n + gradient), 1e-5 * length(done.force_n)) << r.x << " " << r.y << " " << r.z;
    EXPECT_LT(length(done.first_torque_nm + done.second_torque_nm + cross(r, done.force_n)), 1e-9 * lever * length(done.force_n));
}

TEST(Magnets, ForcesAreGradientsAndTorquesBalance) {
    const Vec3 m1{1, 2, -0.5}, m2{-0.3, 1, 2};
    for (const Vec3 r : {Vec3{0.5, 0, 0}, Vec3{0.3, -0.4, 0.2}, Vec3{-0.1, 0.2, 0.6}})
        check_interaction([&](Vec3 at) { return dipoles(m1, m2, at); }, r, 1);
    for (const FeatureKind kind : {FeatureKind::Dipole, FeatureKind::TwoPole, FeatureKind::Plate}) {
        const Feature feature{.kind = kind, .strength = 100, .depth_m = 0.05, .length_m = 0.2, .range_m = 0.3};
        const FeaturePose first{{}, {0, 0, 1}, 1};
        double charge = 0;
        const Vec3 tilted = (1 / length(Vec3{0.2, 0.1, -1})) * Vec3{0.2, 0.1, -1};
        // Near, and near the end of the range.
        for (const Vec3 r : {Vec3{0.02, 0.03, 0.05}, Vec3{0.05, 0.1, 0.15}, Vec3{0.1, 0.1, 0.2}})
            check_interaction([&](Vec3 at) { return interact(feature, first, feature, {at, tilted, -1}, charge); }, r, 1);
        EXPECT_EQ(length(interact(feature, first, feature, {{0, 0, 0.31}, tilted, -1}, charge).force_n), 0);
    }
}

TEST(Magnets, FarTwoPoleMagnetsAreDipoles) {
    const double p = 50, l = 0.02, r = 1;
    const Feature rod{.kind = FeatureKind::TwoPole, .strength = p, .depth_m = 1e-6, .length_m = l, .range_m = 10};
    double charge = 0;
    const Interaction rods = interact(rod, {{0, 0, l / 2}, {0, 0, 1}, 1}, rod, {{0, 0, r - l / 2}, {0, 0, -1}, -1}, charge);
    EXPECT_NEAR(rods.force_n.z / dipoles({0, 0, p * l}, {0, 0, p * l}, {0, 0, r}).force_n.z, 1, 2e-3);
}

TEST(Plates, PullAsTheSquareOfVoltageOverDistance) {
    const Feature plate{.kind = FeatureKind::Plate, .strength = 500, .area_m2 = 0.02, .cover_m = 1e-4, .permittivity = 4};
    const double gap = 2e-4, effective = gap + 2 * 1e-4 / 4;
    const PlatePull pull = plates(plate, plate, 1000, gap);
    EXPECT_NEAR(pull.force_n, kEpsilon0 * 0.02 * 1e6 / (2 * effective * effective), 1e-9);
    EXPECT_NEAR(pull.capacitance_f, kEpsilon0 * 0.02 / effective, 1e-20);
}

// Face to face, from touching to beyond the range, for defaults and for what is deep or shallow, long or short, beside its range.
TEST(Features, ForcesFallMonotonicallyToNothing) {
    for (const FeatureKind kind : {FeatureKind::Dipole, FeatureKind::TwoPole, FeatureKind::Plate})
        for (const double depth : {0.001, 0.05, 0.2})
            for (const double length_m : {0.01, 0.3})
                for (const double range : {0.02, 0.1, 0.6}) {
                    const Feature feature{.kind = kind, .strength = 100, .depth_m = depth, .length_m = length_m, .range_m = range};
                    double before = -std::numeric_limits<double>::infinity(), charge = 0;
                    for (double gap = 0; gap < 1.1 * range; gap += range / 1000) {
                        const Vec3 at{0, 0, gap};
                        const double pull = interact(feature, {{}, {0, 0, 1}, 1}, feature, {at, {0, 0, -1}, -1}, charge).force_n.z;
                        ASSERT_LE(before, pull) << static_cast<int>(kind) << ", depth " << depth << ", range " << range << ", gap " << gap;
                        ASSERT_LE(pull, 0);
                        before = pull;
                    }
                    EXPECT_EQ(before, 0);
                }
}

// The range costs a touching pair of default magnets less than two percent of the force of free dipoles.
TEST(Features, TouchingMagnetsPullAsTheFormulaSays) {
    const Feature magnet{.strength = 10};
    double charge = 0;
    const double pull = interact(magnet, {{}, {0, 0, 1}, 1}, magnet, {{}, {0, 0, -1}, -1}, charge).force_n.z;
    const double free = dipoles({0, 0, 10}, {0, 0, 10}, {0, 0, 0.1}).force_n.z;
    EXPECT_NEAR(pull / free, 1 - std::pow(0.5, 6), 1e-9);
}

TEST(Plates, KnowPolarity) {
    const Feature plate{.kind = FeatureKind::Plate, .strength = 500}, weaker{.kind = FeatureKind::Plate, .strength = 200};
    double charge = 0;
    const auto pull = [&](const Feature& other, double sign) {
        return -interact(plate, {{}, {0, 0, 1}, 1}, other, {{0, 0, 1e-4}, {0, 0, -1}, sign}, charge).force_n.z;
    };
    EXPECT_EQ(pull(plate, 1), 0);
    EXPECT_EQ(charge, 0);
    const double unlike = pull(plate, -1);
    EXPECT_GT(unlike, 0);
    EXPECT_GT(charge, 0);
    // Forces go with the square of the voltage between them.
    EXPECT_NEAR(pull(weaker, -1) / unlike, std::pow(700.0 / 1000, 2), 1e-9);
    EXPECT_NEAR(pull(weaker, 1) / unlike, std::pow(300.0 / 1000, 2), 1e-9);
}

TEST(FeatureTables, DirectionsAreSpreadEvenly) {
    for (const int count : {6, 12, 24}) {
        const std::vector<Vec3> directions = feature_directions(count);
        ASSERT_EQ(directions.size(), static_cast<std::size_t>(count));
        Vec3 sum;
        double nearest = -1;
        for (std::size_t i = 0; i < directions.size(); ++i) {
            EXPECT_NEAR(length(directions[i]), 1, 1e-12);
            sum = sum + directions[i];
            for (std::size_t j = 0; j < i; ++j) nearest = std::max(nearest, dot(directions[i], directions[j]));
        }
        EXPECT_LT(length(sum), 1e-12);
        EXPECT_LT(nearest, count == 6 ? 1e-9 : count == 12 ? 0.51 : 0.75);
    }
}

TEST(FeatureTables, ImpossibleFeaturesAreRefused) {
    EXPECT_FALSE(check_features({{.direction = {0, 0, 0}}}));
    EXPECT_FALSE(check_features({{.strength = -1}}));
    EXPECT_FALSE(check_features({{.range_m = 0}}));
    EXPECT_FALSE(check_features({{.depth_m = 0}}));
    EXPECT_FALSE(check_features({{.kind = FeatureKind::Plate, .cover_m = 0}}));
    EXPECT_FALSE(check_features(std::vector<Feature>(33)));
    EXPECT_TRUE(check_features(std::vector<Feature>(32)));
}

class Actuation : public testing::TestWithParam<EngineKind> {
  protected:
    static std::unique_ptr<Scene> scene_with(Settings settings = {}) {
        settings.engine = GetParam();
        if (GetParam() != EngineKind::Blocks) settings.solver = SolverSettings::pgs20();
        return make_scene(settings);
    }
    // A table of the same feature in the given directions.
    static std::uint16_t add_table(Scene& scene, Feature feature, const std::vector<Vec3>& directions) {
        std::vector<Feature> features;
        for (const Vec3 direction : directions) features.push_back(feature), features.back().direction = direction;
        return need(scene.add_feature_table(features));
    }
    Workers workers_{1};
};

// Two balls with magnets face to face come together; what they gain in speed the field loses, and momentum stays.
TEST_P(Actuation, MagnetsPullBallsTogetherAndKeepEnergy) {
    auto scene = scene_with({.gravity_m_s2 = {}});
    const Feature magnet{.strength = 400, .depth_m = 0.2, .range_m = 0.6};
    const auto table = add_table(*scene, magnet, {{1, 0, 0}, {-1, 0, 0}});
    const double gap = 0.3;
    for (const BodyId id : {0u, 1u}) {
        need(scene->add_body({.id = id, .position_m = {(1 + gap) * id, 0, 0}}));
        need(scene->set_feature_table(id, table));
    }
    // The magnets on the facing sides, one turned inwards so that the fields agree.
    need(scene->set_features(0, 1, 0));
    need(scene->set_features(1, 2, 2));
    const auto field_energy = [&] {
        double charge = 0;
        const double apart = scene->state(1).position_m.x - scene->state(0).position_m.x - 1;
        return interact(magnet, {{}, {1, 0, 0}, 1}, magnet, {{apart, 0, 0}, {-1, 0, 0}, -1}, charge).energy_j;
    };
    const double before = field_energy();
    ASSERT_LT(before, 0);
    int ticks = 0;
    while (scene->state(1).position_m.x - scene->state(0).position_m.x > 1.03 && ticks < 2000) {
        run(*scene, 1, 4, workers_);
        ++ticks;
        EXPECT_NEAR(scene->kinetic_energy_j() + field_energy(), before, 0.03 * std::abs(field_energy() - before) + 1e-4);
    }
    EXPECT_LT(ticks, 2000);
    EXPECT_GT(scene->kinetic_energy_j(), 1e-3);
    EXPECT_LT(length(scene->momentum()), 1e-5);
    run(*scene, 240, 2, workers_);
    EXPECT_EQ(scene->contacts().size(), 1u);
}

TEST_P(Actuation, EqualPolesPushApart) {
    auto scene = scene_with({.gravity_m_s2 = {}});
    const auto table = add_table(*scene, {.strength = 400, .depth_m = 0.2, .range_m = 0.6}, {{1, 0, 0}, {-1, 0, 0}});
    for (const BodyId id : {0u, 1u}) {
        need(scene->add_body({.id = id, .position_m = {1.001 * id, 0, 0}}));
        need(scene->set_feature_table(id, table));
        need(scene->set_features(id, id == 0 ? 1 : 2, 0));
    }
    run(*scene, 120, 2, workers_);
    EXPECT_GT(scene->state(1).linear_velocity_m_s.x, 0.01);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, -scene->state(1).linear_velocity_m_s.x, 1e-6);
}

// A chain of balls hangs from a fixed one by its latches as long as the uppermost holds the weight below.
TEST_P(Actuation, ChainHangsFromLatchesThatAreStrongEnough) {
    const int links = 6;
    const double weight = links * 9.81;
    for (const double strength : {1.15 * weight, 0.8 * weight}) {
        auto scene = scene_with({.sleep_ticks = 0});
        const auto table = add_table(*scene, {.kind = FeatureKind::Latch, .strength = strength, .range_m = 0.05}, {{0, 0, 1}, {0, 0, -1}});
        for (BodyId id = 0; id <= links; ++id) {
            need(scene->add_body({.id = id, .position_m = {0, 0, -1.0 * id}, .fixed = id == 0}));
            need(scene->set_feature_table(id, table));
            need(scene->set_features(id, 3, 0));
        }
        run(*scene, 240, 2, workers_);
        const double hung = -scene->state(links).position_m.z;
        if (strength > weight) {
            EXPECT_NEAR(hung, links, 0.01);
            EXPECT_LT(std::sqrt(2 * scene->kinetic_energy_j() / links), 0.05);
            bool found = false;
            for (const ContactReport& contact : scene->contacts())
                if (contact.touch == Touch{0, 1, false}) {
                    found = true;
                    EXPECT_NEAR(contact.normal_force_n, -weight, 0.1 * weight);
                }
            EXPECT_TRUE(found);
        } else {
            EXPECT_GT(hung, links + 0.5);
        }
    }
}

TEST_P(Actuation, LatchLetsGoWhenSwitchedOff) {
    auto scene = scene_with();
    const auto table = add_table(*scene, {.kind = FeatureKind::Latch, .strength = 100, .range_m = 0.05}, {{0, 0, 1}, {0, 0, -1}});
    for (BodyId id = 0; id < 2; ++id) {
        need(scene->add_body({.id = id, .position_m = {0, 0, -1.0 * id}, .fixed = id == 0}));
        need(scene->set_feature_table(id, table));
        need(scene->set_features(id, 3, 0));
    }
    run(*scene, 200, 2, workers_);
    EXPECT_NEAR(scene->state(1).position_m.z, -1, 5e-3);
    EXPECT_EQ(scene->asleep(1), GetParam() == EngineKind::Blocks);
    need(scene->set_features(0, 0, 0));
    run(*scene, 120, 2, workers_);
    EXPECT_LT(scene->state(1).position_m.z, -2);
}

// One catom rolls around another: always the next pair of magnets along the way is on. Both have 12 in the plane, so that
// each step turns the roller by 60 degrees and brings it 30 degrees around.
TEST_P(Actuation, SwitchingMagnetsRollsOneBallAroundAnother) {
    auto scene = scene_with({.gravity_m_s2 = {}, .linear_damping_per_s = 5, .angular_damping_per_s = 5});
    const auto rough = need(scene->add_material({.friction = 1}));
    const int count = 12;
    std::vector<Vec3> ring;
    for (int i = 0; i < count; ++i)
        ring.push_back({std::cos(2 * std::numbers::pi * i / count), std::sin(2 * std::numbers::pi * i / count), 0});
    const auto table = add_table(*scene, {.strength = 600, .depth_m = 0.15, .range_m = 0.6}, ring);
    need(scene->add_body({.id = 0, .material = rough, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {1, 0, 0}, .material = rough}));
    for (const BodyId id : {0u, 1u}) need(scene->set_feature_table(id, table));
    const auto angle = [&] {
        const Vec3 p = scene->state(1).position_m;
        return std::atan2(p.y, p.x);
    };
    for (int step = 0; step <= 3; ++step) {
        // Roller's magnet that meets the fixed one's magnet `step`: rolling by `step` turns the contact point back by as much.
        const int fixed = step, rolling = ((count / 2 - step) % count + count) % count;
        need(scene->set_features(0, 1u << fixed, 0));
        need(scene->set_features(1, 1u << rolling, 1u << rolling));
        run(*scene, 480, 2, workers_);
        EXPECT_NEAR(angle(), step * std::numbers::pi / 6, 0.06) << step;
        EXPECT_NEAR(length(scene->state(1).position_m), 1, 0.01);
    }
}

TEST_P(Actuation, EnergyIsDrawnWhileOnAtSwitchingAndForCharging) {
    auto scene = scene_with({.gravity_m_s2 = {}, .sleep_ticks = 0});
    const Feature magnet{.direction = {0, 0, 1}, .strength = 0, .power_w = 2, .switching_j = 0.25};
    const Feature plate{.direction = {1, 0, 0},
                        .kind = FeatureKind::Plate,
                        .strength = 100,
                        .area_m2 = 0.05,
                        .cover_m = 1e-3,
                        .permittivity = 2,
                        .range_m = 0.1};
    Feature other = plate;
    other.direction = {-1, 0, 0};
    const auto table = need(scene->add_feature_table({magnet, plate, other}));
    for (const BodyId id : {0u, 1u}) {
        need(scene->add_body({.id = id, .position_m = {1.001 * id, 0, 0}, .fixed = true}));
        need(scene->set_feature_table(id, table));
    }
    need(scene->add_body({.id = 2, .position_m = {5, 0, 0}}));
    need(scene->set_features(0, 1, 0));
    run(*scene, 120, 1, workers_);
    EXPECT_NEAR(scene->energy_drawn_j(0), 2 * 0.5 + 0.25, 1e-9);
    EXPECT_EQ(scene->energy_drawn_j(1), 0);
    need(scene->set_features(0, 2, 0));
    need(scene->set_features(1, 4, 4));
    const double before = scene->energy_drawn_j(0);
    run(*scene, 10, 1, workers_);
    // Fixed bodies do not search for each other: no pair, no charge. A free one finds the plate.
    EXPECT_EQ(scene->energy_drawn_j(0), before);
    need(scene->remove_body(1));
    run(*scene, 1, 1, workers_);
    need(scene->add_body({.id = 1, .position_m = {1.001, 0, 0}}));
    need(scene->set_feature_table(1, table));
    need(scene->set_features(1, 4, 4));
    run(*scene, 240, 1, workers_);
    const double gap = scene->state(1).position_m.x - 1;
    const double charge = plates(plate, plate, 200, gap).capacitance_f * 200 * 200;
    EXPECT_NEAR(scene->energy_drawn_j(0) - before, charge / 2, 0.05 * charge);
    EXPECT_NEAR(scene->energy_drawn_j(1), charge / 2, 0.05 * charge);
}

INSTANTIATE_TEST_SUITE_P(Engines, Actuation, testing::Values(EngineKind::Blocks, EngineKind::Hash, EngineKind::Ode),
                         [](const auto& engine) {
                             return engine.param == EngineKind::Blocks ? "Blocks" : engine.param == EngineKind::Hash ? "Hash" : "Ode";
                         });

}  // namespace
}  // namespace meld::physics
