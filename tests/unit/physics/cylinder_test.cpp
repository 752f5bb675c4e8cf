// Cylinders against mechanics: what slides, tips, stands, rolls and spins.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "physics/scene/scene.h"
#include "tests/unit/physics/snapshots.h"

// Names as in the tests of other shapes.
namespace meld::physics::cylinders {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
const Quat kLying{std::sqrt(0.5), std::sqrt(0.5), 0, 0};

Settings awake() {
    Settings settings;
    settings.sleep_ticks = 0;
    return settings;
}

// Level ground, and gravity as on a slope that goes down along a direction.
std::unique_ptr<Scene> slope(double degrees, float friction, double heading = 0) {
    Settings settings = awake();
    const double down = std::sin(degrees * kDegree);
    settings.gravity_m_s2 = kGravity * Vec3{down * std::cos(heading), down * std::sin(heading), -std::cos(degrees * kDegree)};
    auto scene = make_scene(settings);
    need(scene->add_material({.friction = friction}));
    need(scene->add_obstacle(Plane{}, 1));
    return scene;
}

Vec3 up(const Scene& scene, BodyId body) { return rotate(scene.state(body).orientation, {0, 0, 1}); }

TEST(Cylinders, HaveTheInertiaOfSolids) {
    const BodyShape sharp = cylinder_shape(0.4, 1.2, 0);
    EXPECT_NEAR(sharp.volume_m3(), std::numbers::pi * 0.16 * 1.2, 1e-12);
    EXPECT_NEAR(sharp.surface_m2(), 2 * std::numbers::pi * 0.16 + 0.8 * std::numbers::pi * 1.2, 1e-12);
    EXPECT_NEAR(sharp.inertia_per_kg_m2().z, 0.08, 1e-12);
    EXPECT_NEAR(sharp.inertia_per_kg_m2().x, 0.04 + 0.12, 1e-12);
    // With a round rim, by counting points.
    const BodyShape rounded = cylinder_shape(0.6, 1, 0.25);
    double inside = 0, across = 0, along = 0;
    constexpr int kSteps = 140;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j)
            for (int k = 0; k < kSteps; ++k) {
                const Vec3 at{1.2 * ((i + 0.5) / kSteps - 0.5), 1.2 * ((j + 0.5) / kSteps - 0.5), (k + 0.5) / kSteps - 0.5};
                const double out = std::max(std::hypot(at.x, at.y) - 0.35, 0.0), over = std::max(std::abs(at.z) - 0.25, 0.0);
                if (std::hypot(out, over) > 0.25) continue;
                ++inside, along += at.x * at.x + at.y * at.y, across += at.y * at.y + at.z * at.z;
            }
    EXPECT_NEAR(inside * 1.44 / (kSteps * kSteps * kSteps), rounded.volume_m3(), 2e-3 * rounded.volume_m3());
    EXPECT_NEAR(along / inside, rounded.inertia_per_kg_m2().z, 2e-3 * rounded.inertia_per_kg_m2().z);
    EXPECT_NEAR(across / inside, rounded.inertia_per_kg_m2().x, 2e-3 * rounded.inertia_per_kg_m2().x);
    // Its surface is how fast the volume grows with the rounding.
    const auto grown = [](double by) { return BodyShape({0.35, 0, 0.25}, 0.25 + by).volume_m3(); };
    EXPECT_NEAR((grown(1e-5) - grown(-1e-5)) / 2e-5, rounded.surface_m2(), 1e-6);
    EXPECT_DOUBLE_EQ(rounded.least_m(), 0.5);
    EXPECT_FALSE(check(cylinder_shape(0.6, 1, 0.5)));
    EXPECT_TRUE(check(cylinder_shape(0.6, 1, 0.49)));
}

TEST(Cylinders, RollDownASlope) {
    constexpr double kDegrees = 10;
    Workers workers(1);
    for (const double rounding : {0.0, 0.02}) {
        auto scene = slope(kDegrees, 1);
        need(scene->add_body(
            {.id = 0, .position_m = {0, 0, 0.25}, .orientation = kLying, .material = 1, .shape = cylinder_shape(0.25, 1.5, rounding)}));
        run(*scene, 480, 2, workers);
        const double expected = (rounding == 0 ? 2.0 / 3 : 1 / (1 + cylinder_shape(0.25, 1.5, rounding).inertia_per_kg_m2().z * 16)) *
                                kGravity * std::sin(kDegrees * kDegree);
        EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 2 * expected, 0.005 * 2 * expected);
        EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.y, 2 * expected / 0.25, 0.005 * 2 * expected / 0.25);
        EXPECT_NEAR(scene->state(0).position_m.y, 0, 1e-3);
    }
}

TEST(Cylinders, RollDownABoxAndOverAnother) {
    constexpr double kDegrees = 10;
    auto scene = slope(kDegrees, 1);
    need(scene->add_obstacle(Box{{10, 0, 0.5}, {30, 4, 1}, {}}, 1));
    need(scene->add_body(
        {.id = 0, .position_m = {0, 0, 1.25}, .orientation = kLying, .material = 1, .shape = cylinder_shape(0.25, 1.5, 0)}));
    Workers workers(1);
    run(*scene, 480, 2, workers);
    const double expected = 2.0 / 3 * kGravity * std::sin(kDegrees * kDegree);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 2 * expected, 0.005 * 2 * expected);
    EXPECT_NEAR(scene->state(0).position_m.y, 0, 1e-3);
}

TEST(Cylinders, SlideAtTheAngleOfFriction) {
    Workers workers(1);
    const double limit = std::atan(0.5) / kDegree;
    for (const double heading : {0.0, 0.7})
        for (const double degrees : {limit - 0.3, limit + 0.3}) {
            auto scene = slope(degrees, 0.5f, heading);
            need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .material = 1, .shape = cylinder_shape(1, 1, 0)}));
            run(*scene, 480, 2, workers);
            const double rest = kGravity * (std::sin(degrees * kDegree) - 0.5 * std::cos(degrees * kDegree));
            const Vec3 velocity = scene->state(0).linear_velocity_m_s;
            if (degrees < limit)
                EXPECT_LT(length(scene->state(0).position_m - Vec3{0, 0, 0.5}), 1e-3) << degrees;
            else
                EXPECT_NEAR(std::hypot(velocity.x, velocity.y), 2 * rest, 0.02 * 2 * rest) << degrees;
            EXPECT_GT(up(*scene, 0).z, 0.999);
        }
}

// A force on the centre turns what pulls at it more and more, in the end by a tenth of a degree a second, in directions that are alike and
// not alike the body's axes.
TEST(Cylinders, TipWhenTheirWeightPointsOverTheRim) {
    Workers workers(1);
    for (const double heading : {0.0, 0.4, std::numbers::pi / 4})
        for (const auto& [height, rounding] : {std::pair(1.0, 0.0), std::pair(2.0, 0.0), std::pair(1.0, 0.05)}) {
            const double limit = std::atan2(0.5 - rounding, height / 2) / kDegree;
            auto scene = slope(0, 3);
            need(scene->add_body(
                {.id = 0, .position_m = {0, 0, height / 2}, .material = 1, .shape = cylinder_shape(0.5, height, rounding)}));
            double degrees = 0;
            for (int tick = 0; up(*scene, 0).z > 0.999; ++tick) {
                degrees = std::min(tick / 200.0, limit - 2 + std::max(tick - 200 * (limit - 2), 0.0) / 2400);
                ASSERT_LT(degrees, limit + 1);
                const double force = kGravity * std::tan(degrees * kDegree);
                need(scene->set_wrench(0, {force * std::cos(heading), force * std::sin(heading), 0}, {}));
                run(*scene, 1, 2, workers);
            }
            EXPECT_NEAR(degrees, limit, 0.3) << height << ' ' << heading << ' ' << rounding;
        }
}

TEST(Cylinders, AStackStandsAwake) {
    Workers workers(1);
    for (const double offset : {0.0, 0.05}) {
        auto scene = scene_on_plane(awake());
        for (BodyId id = 0; id < 10; ++id)
            need(scene->add_body({.id = id, .position_m = {id % 2 == 0 ? 0 : offset, 0, 0.5 + id}, .shape = cylinder_shape(0.5, 1, 0.02)}));
        run(*scene, 2400, 2, workers);
        double weight = 0;
        for (BodyId id = 0; id < 10; ++id) {
            const Vec3 at = scene->state(id).position_m;
            EXPECT_NEAR(at.x, id % 2 == 0 ? 0 : offset, 0.02) << id;
            EXPECT_NEAR(at.y, 0, 0.02) << id;
            EXPECT_NEAR(at.z, 0.5 + id, 0.01 * (1 + id)) << id;
            EXPECT_GT(up(*scene, id).z, 0.9999) << id;
            EXPECT_LT(speed(*scene, id), 0.01) << id;
            EXPECT_FALSE(scene->asleep(id));
        }
        for (const ContactReport& contact : scene->contacts())
            if (contact.touch.other_is_obstacle) weight += contact.normal_force_n;
        EXPECT_NEAR(weight, 10 * kGravity, 0.01 * 10 * kGravity);
    }
}

TEST(Cylinders, APyramidOfLyingOnesStandsBetweenWalls) {
    auto scene = scene_on_plane(awake());
    for (const Vec3 side : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}}) need(scene->add_obstacle(Plane{side, -2}, 0));
    BodyId id = 0;
    for (int row = 0; row < 4; ++row)
        for (int i = 0; i < 4 - row; ++i, ++id)
            need(scene->add_body({.id = id,
                                  .position_m = {-1.5 + i + 0.5 * row, 0, 0.5 + row * std::sqrt(0.75)},
                                  .orientation = kLying,
                                  .shape = cylinder_shape(0.5, 2, 0.02)}));
    Workers workers(1);
    run(*scene, 1200, 2, workers);
    EXPECT_NEAR(scene->state(9).position_m.z, 0.5 + 3 * std::sqrt(0.75), 0.02);
    EXPECT_LT(scene->kinetic_energy_j(), 1e-4);
}

TEST(Cylinders, ASpinningOneComesToRestByFriction) {
    auto scene = slope(0, 0.5f);
    need(scene->add_body(
        {.id = 0, .position_m = {0, 0, 0.25}, .angular_velocity_rad_s = {0, 0, 20}, .material = 1, .shape = cylinder_shape(0.5, 0.5, 0)}));
    Workers workers(1);
    run(*scene, 120, 2, workers);
    // Points on the rim rub at its radius: the torque is mu m g R, and the inertia m R^2 / 2.
    const double slower = 2 * 0.5 * kGravity / 0.5;
    EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, 20 - 0.5 * slower, 0.05 * 0.5 * slower);
    run(*scene, 240, 2, workers);
    EXPECT_LT(length(scene->state(0).angular_velocity_rad_s), 1e-3);
    EXPECT_LT(length(scene->state(0).position_m - Vec3{0, 0, 0.25}), 0.01);
    EXPECT_GT(up(*scene, 0).z, 0.9999);
}

TEST(Cylinders, ACoinThatLeansFallsOnItsFace) {
    auto scene = slope(0, 0.8f);
    need(scene->add_body({.id = 0,
                          .position_m = {0, 0, 0.5},
                          .orientation = {std::cos(0.9), std::sin(0.9), 0, 0},
                          .linear_velocity_m_s = {0.1, 0, 0},
                          .angular_velocity_rad_s = {0, 0.2, 0},
                          .material = 1,
                          .shape = cylinder_shape(0.5, 0.08, 0.005)}));
    Workers workers(1);
    double energy = HUGE_VAL, most_growth = 0;
    for (int tick = 0; tick < 240 * 10; ++tick) {
        run(*scene, 1, 2, workers);
        const double now = scene->kinetic_energy_j() + kGravity * scene->state(0).position_m.z;
        most_growth = std::max(most_growth, now - energy);
        energy = std::min(energy, now);
    }
    EXPECT_LT(most_growth, 0.01 * kGravity * 0.5);
    EXPECT_GT(std::abs(up(*scene, 0).z), 0.9999);
    EXPECT_LT(scene->kinetic_energy_j(), 1e-4);
}

TEST(Cylinders, CollisionsKeepMomentum) {
    Settings settings = awake();
    settings.gravity_m_s2 = {};
    auto scene = make_scene(settings);
    add_implosion(*scene, 9, [](BodySpec& spec) {
        const BodyId id = spec.id;
        if (id % 4 == 0) spec.shape = box_shape({0.8, 0.7, 0.9}, 0.05);
        if (id % 4 == 1) spec.shape = capsule_shape(0.3, 1.2);
        if (id % 4 >= 2) spec.shape = cylinder_shape(0.4, id % 8 >= 4 ? 0.9 : 0.3, id % 4 == 2 ? 0.03 : 0);
    });
    expect_kept_momentum(*scene);
}

// All kinds of shapes.
std::unique_ptr<Scene> pile_of_all(int layers) {
    return walled_pile(layers, [](BodySpec& spec) {
        const BodyId kind = spec.id % 7;
        if (kind == 0) spec.shape = box_shape({0.8, 0.8, 0.8}, 0.02);
        if (kind == 1) spec.shape = capsule_shape(0.3, 1.2);
        if (kind == 2) spec.radius_m = 0.4;
        if (kind == 3) spec.shape = cylinder_shape(0.4, 0.8, 0.02);
        if (kind == 4) spec.shape = cylinder_shape(0.3, 1.1, 0);
        if (kind == 5) spec.shape = cylinder_shape(0.5, 0.2, 0.01);
        if (kind == 6) spec.shape = cylinder_shape(0.35, 0.7, 0.1);
    });
}

double energy_of(const Scene& scene) {
    double sum = scene.kinetic_energy_j();
    for (const BodyId id : scene.bodies()) sum += kGravity * scene.state(id).position_m.z;
    return sum;
}

TEST(Cylinders, APileLosesEnergyAndComesToRest) {
    auto scene = pile_of_all(6);
    Workers workers(2);
    double energy = energy_of(*scene), most_growth = 0;
    for (int tick = 0; tick < 240 * 8; ++tick) {
        run(*scene, 1, 2, workers);
        const double now = energy_of(*scene);
        most_growth = std::max(most_growth, now - energy);
        energy = std::min(energy, now);
    }
    // Overlaps of the least kind give back a little of what they took.
    EXPECT_LT(most_growth, 1e-3 * 96 * kGravity);
    EXPECT_LT(scene->kinetic_energy_j(), 0.05);
    double deepest = 0;
    for (const ContactReport& contact : scene->contacts()) deepest = std::max(deepest, -contact.gap_m);
    EXPECT_LT(deepest, 0.01);
    for (const BodyId id : scene->bodies()) {
        EXPECT_GT(scene->state(id).position_m.z, 0.09) << id;
        EXPECT_LT(std::abs(scene->state(id).position_m.x), 3) << id;
    }
}

TEST(Cylinders, AnyNumberOfWorkersGivesTheSameBits) {
    Digest first;
    for (const int threads : {1, 2, 3}) {
        auto scene = pile_of_all(3);
        Workers workers(threads);
        run(*scene, 400, 2, workers);
        if (threads == 1) first = scene->digest();
        EXPECT_EQ(scene->digest(), first) << threads;
    }
}

TEST(Cylinders, AreSavedAndLoaded) {
    auto scene = pile_of_all(2);
    Workers workers(2);
    for (int i = 0; i < 6; ++i) {
        run(*scene, 43, 2, workers);
        const auto other = loaded(saved(*scene), pile_of_all(0), workers);
        EXPECT_EQ(other->digest(), scene->digest());
        EXPECT_EQ(other->shape(3), scene->shape(3));
        run(*other, 30, 2, workers);
        run(*scene, 30, 2, workers);
        EXPECT_EQ(other->digest(), scene->digest()) << i;
    }
}

}  // namespace
}  // namespace meld::physics::cylinders
