// Boxes and capsules against mechanics: what slides, tips, stands, rolls, spins and bounces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "physics/scene/scene.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Settings awake() {
    Settings settings;
    settings.sleep_ticks = 0;
    return settings;
}

// Level ground, and gravity as on a slope that goes down along x.
std::unique_ptr<Scene> slope(double degrees, float friction) {
    Settings settings = awake();
    settings.gravity_m_s2 = kGravity * Vec3{std::sin(degrees * kDegree), 0, -std::cos(degrees * kDegree)};
    auto scene = make_scene(settings);
    need(scene->add_material({.friction = friction}));
    need(scene->add_obstacle(Plane{}, 1));
    return scene;
}

Vec3 up(const Scene& scene, BodyId body) { return rotate(scene.state(body).orientation, {0, 0, 1}); }

TEST(Shapes, HaveTheInertiaOfSolids) {
    const auto expect = [](Vec3 found, Vec3 wanted) {
        for (const auto& [one, other] : {std::pair(found.x, wanted.x), std::pair(found.y, wanted.y), std::pair(found.z, wanted.z)})
            EXPECT_NEAR(one, other, 1e-9 + 1e-9 * std::abs(other));
    };
    expect(BodyShape({}, 2).inertia_per_kg_m2(), {1.6, 1.6, 1.6});
    expect(box_shape({1, 2, 3}, 0).inertia_per_kg_m2(), {13.0 / 12, 10.0 / 12, 5.0 / 12});
    // A cylinder with half balls at its ends, from the textbook.
    const double r = 0.3, h = 1.4, cylinder = std::numbers::pi * r * r * h, balls = 4.0 / 3 * std::numbers::pi * r * r * r;
    const double mass = cylinder + balls;
    const double along = (cylinder * r * r / 2 + balls * 2 * r * r / 5) / mass;
    const double across = (cylinder * (h * h / 12 + r * r / 4) + balls * (2 * r * r / 5 + h * h / 4 + 3 * h * r / 8)) / mass;
    expect(capsule_shape(r, h + 2 * r).inertia_per_kg_m2(), {across, across, along});
    EXPECT_NEAR(capsule_shape(r, h + 2 * r).volume_m3(), mass, 1e-12);
    // A rounded box, by counting points.
    const BodyShape rounded = box_shape({1, 1.5, 2}, 0.3);
    double inside = 0, xx = 0, yy = 0, zz = 0;
    constexpr int kSteps = 120;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j)
            for (int k = 0; k < kSteps; ++k) {
                const Vec3 at{(i + 0.5) / kSteps - 0.5, 1.5 * ((j + 0.5) / kSteps - 0.5), 2 * ((k + 0.5) / kSteps - 0.5)};
                const Vec3 away{std::max(std::abs(at.x) - rounded.core_m.x, 0.0), std::max(std::abs(at.y) - rounded.core_m.y, 0.0),
                                std::max(std::abs(at.z) - rounded.core_m.z, 0.0)};
                if (length(away) > rounded.rounding_m) continue;
                ++inside, xx += at.x * at.x, yy += at.y * at.y, zz += at.z * at.z;
            }
    const Vec3 found = rounded.inertia_per_kg_m2();
    EXPECT_NEAR(inside * 3 / (kSteps * kSteps * kSteps), rounded.volume_m3(), 2e-3 * rounded.volume_m3());
    EXPECT_NEAR(found.x, (yy + zz) / inside, 2e-3 * found.x);
    EXPECT_NEAR(found.y, (xx + zz) / inside, 2e-3 * found.y);
    EXPECT_NEAR(found.z, (xx + yy) / inside, 2e-3 * found.z);
}

TEST(Shapes, ABoxSlidesAtTheAngleOfFriction) {
    Workers workers(1);
    const double limit = std::atan(0.5) / kDegree;
    for (const double degrees : {limit - 0.3, limit + 0.3}) {
        auto scene = slope(degrees, 0.5f);
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .material = 1, .shape = box_shape({2, 2, 1}, 0)}));
        run(*scene, 480, 2, workers);
        if (degrees < limit) {
            EXPECT_LT(scene->state(0).position_m.x, 1e-3) << degrees;
        } else {
            // By what friction leaves of gravity.
            const double rest = kGravity * (std::sin(degrees * kDegree) - 0.5 * std::cos(degrees * kDegree));
            EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 2 * rest, 0.02 * 2 * rest) << degrees;
        }
        EXPECT_GT(up(*scene, 0).z, 0.999);
    }
}

TEST(Shapes, ABoxTipsWhenItsCentreIsOverTheEdge) {
    Workers workers(1);
    for (const auto& [height, rounding] : {std::pair(1.0, 0.0), std::pair(2.0, 0.0), std::pair(1.0, 0.05)}) {
        const double limit = std::atan2(0.5 - rounding, height / 2) / kDegree;
        for (const double degrees : {limit - 0.3, limit + 0.3}) {
            auto scene = slope(degrees, 3);
            need(scene->add_body({.id = 0, .position_m = {0, 0, height / 2}, .material = 1, .shape = box_shape({1, 1, height}, rounding)}));
            run(*scene, 960, 2, workers);
            if (degrees < limit)
                EXPECT_GT(up(*scene, 0).z, 0.999) << height << ' ' << degrees;
            else
                EXPECT_LT(up(*scene, 0).z, 0.9) << height << ' ' << degrees;
        }
    }
}

TEST(Shapes, AStackOfCubesStandsAwake) {
    auto scene = scene_on_plane(awake());
    for (BodyId id = 0; id < 30; ++id)
        need(scene->add_body({.id = id, .position_m = {0, 0, 0.5 + id}, .shape = box_shape({1, 1, 1}, 0.02)}));
    Workers workers(1);
    run(*scene, 2400, 2, workers);
    for (BodyId id = 0; id < 30; ++id) {
        const Vec3 at = scene->state(id).position_m;
        EXPECT_NEAR(at.x, 0, 0.02) << id;
        EXPECT_NEAR(at.y, 0, 0.02) << id;
        EXPECT_NEAR(at.z, 0.5 + id, 0.01 * (1 + id)) << id;
        EXPECT_GT(up(*scene, id).z, 0.9999) << id;
        EXPECT_LT(speed(*scene, id), 0.01) << id;
        EXPECT_FALSE(scene->asleep(id));
    }
    // Each carries what is above it.
    double weight = 0;
    for (const ContactReport& contact : scene->contacts())
        if (contact.touch.other_is_obstacle) weight += contact.normal_force_n;
    EXPECT_NEAR(weight, 30 * kGravity, 0.01 * 30 * kGravity);
}

TEST(Shapes, AStackFallsAsleep) {
    auto scene = scene_on_plane();
    for (BodyId id = 0; id < 10; ++id)
        need(scene->add_body({.id = id, .position_m = {0, 0, 0.5 + id}, .shape = box_shape({1, 1, 1}, 0.02)}));
    Workers workers(1);
    run(*scene, 1440, 2, workers);
    EXPECT_EQ(scene->awake_bodies(), 0u);
    // A push wakes it.
    need(scene->set_wrench(9, {30, 0, 0}, {}));
    run(*scene, 120, 2, workers);
    EXPECT_GT(scene->state(9).position_m.x, 0.5);
}

TEST(Shapes, ARowOfDominoesFalls) {
    auto scene = scene_on_plane();
    constexpr BodyId kCount = 50;
    for (BodyId id = 0; id < kCount; ++id)
        need(scene->add_body({.id = id, .position_m = {0.6 * id, 0, 0.5}, .shape = box_shape({0.15, 0.5, 1}, 0.005)}));
    Workers workers(1);
    run(*scene, 240, 2, workers);
    for (BodyId id = 0; id < kCount; ++id) EXPECT_GT(up(*scene, id).z, 0.9999) << id;
    // The first is tipped over its edge.
    BodyState first = scene->state(0);
    first.angular_velocity_rad_s = {0, 2.5, 0};
    need(scene->set_state(0, first));
    run(*scene, 240 * 12, 2, workers);
    for (BodyId id = 0; id < kCount; ++id) {
        EXPECT_LT(up(*scene, id).z, 0.8) << id;
        EXPECT_GT(up(*scene, id).x, 0.3) << id;
    }
}

TEST(Shapes, ACapsuleRollsDownASlope) {
    constexpr double kDegrees = 10;
    auto scene = slope(kDegrees, 1);
    const BodyShape shape = capsule_shape(0.25, 1.5);
    // Its axis lies across the slope.
    need(scene->add_body(
        {.id = 0, .position_m = {0, 0, 0.25}, .orientation = {std::sqrt(0.5), std::sqrt(0.5), 0, 0}, .material = 1, .shape = shape}));
    Workers workers(1);
    run(*scene, 480, 2, workers);
    const double lazy = shape.inertia_per_kg_m2().z / (0.25 * 0.25);
    const double expected = kGravity * std::sin(kDegrees * kDegree) / (1 + lazy);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 2 * expected, 0.005 * 2 * expected);
    EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.y, 2 * expected / 0.25, 0.005 * 2 * expected / 0.25);
}

TEST(Shapes, AFreeSpinKeepsItsMomentumAndEnergy) {
    Settings settings = awake();
    settings.gravity_m_s2 = {};
    auto scene = make_scene(settings);
    // About the middle axis, where it turns over again and again.
    need(scene->add_body({.id = 0, .angular_velocity_rad_s = {0.01, 6, 0.01}, .shape = box_shape({0.4, 0.9, 1.5}, 0.1)}));
    const Vec3 momentum = scene->angular_momentum();
    const double energy = scene->kinetic_energy_j();
    Workers workers(1);
    bool turned_over = false;
    for (int i = 0; i < 20; ++i) {
        run(*scene, 120, 2, workers);
        turned_over = turned_over || rotate(scene->state(0).orientation, {0, 1, 0}).y < -0.5;
        EXPECT_LT(length(scene->angular_momentum() - momentum), 1e-3 * length(momentum));
        EXPECT_NEAR(scene->kinetic_energy_j(), energy, 0.01 * energy);
    }
    EXPECT_TRUE(turned_over);
}

TEST(Shapes, ATorqueTurnsByTheTensor) {
    Settings settings = awake();
    settings.gravity_m_s2 = {};
    auto scene = make_scene(settings);
    const BodyShape shape = box_shape({0.4, 0.9, 1.5}, 0.1);
    need(scene->add_body({.id = 0, .orientation = {std::sqrt(0.5), 0, std::sqrt(0.5), 0}, .mass_kg = 2, .shape = shape}));
    // Its own x axis points along -z of the world.
    need(scene->set_wrench(0, {}, {0, 0, 0.3}));
    Workers workers(1);
    run(*scene, 120, 2, workers);
    EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, 0.5 * 0.3 / (2 * shape.inertia_per_kg_m2().x), 1e-3);
}

TEST(Shapes, AFaceThatLandsFlatLeavesFlat) {
    for (const double share : {0.5, 0.9}) {
        auto scene = make_scene(awake());
        need(scene->add_material({.friction = 0.5f, .restitution = static_cast<float>(share)}));
        need(scene->add_obstacle(Plane{}, 1));
        need(scene->add_body({.id = 0, .position_m = {0, 0, 2.5}, .material = 1, .shape = box_shape({1, 1, 1}, 0.02)}));
        Workers workers(1);
        double top = 0;
        bool rises = false;
        for (int tick = 0; tick < 480; ++tick) {
            run(*scene, 1, 2, workers);
            rises = rises || scene->state(0).linear_velocity_m_s.z > 0.1;
            if (rises) top = std::max(top, scene->state(0).position_m.z);
        }
        EXPECT_NEAR(top - 0.5, share * share * 2, 0.05 * share * share * 2) << share;
        EXPECT_GT(up(*scene, 0).z, 0.9999);
    }
}

TEST(Shapes, CollisionsKeepMomentum) {
    Settings settings = awake();
    settings.gravity_m_s2 = {};
    auto scene = make_scene(settings);
    add_implosion(*scene, 7, [](BodySpec& spec) {
        if (spec.id % 3 == 0) spec.shape = box_shape({0.8, 0.7, 0.9}, 0.05);
        if (spec.id % 3 == 1) spec.shape = capsule_shape(0.3, 1.2);
    });
    expect_kept_momentum(*scene);
}

// Boxes, capsules and balls.
std::unique_ptr<Scene> pile(int layers) {
    return walled_pile(layers, [](BodySpec& spec) {
        const BodyId kind = spec.id % 4;
        if (kind == 0) spec.shape = box_shape({0.8, 0.8, 0.8}, 0.02);
        if (kind == 1) spec.shape = box_shape({0.5, 0.7, 1.1}, 0.1);
        if (kind == 2) spec.shape = capsule_shape(0.3, 1.2);
        if (kind == 3) spec.radius_m = 0.4;
    });
}

TEST(Shapes, APileComesToRestWithoutDeepOverlaps) {
    auto scene = pile(6);
    Workers workers(2);
    // When the last one has come down from the others depends on every bit; then all stay where they are.
    int seconds = 0;
    do run(*scene, 240, 2, workers);
    while (++seconds < 16 && scene->kinetic_energy_j() > 0.05);
    EXPECT_LT(seconds, 16);
    run(*scene, 240, 2, workers);
    EXPECT_LT(scene->kinetic_energy_j(), 0.05);
    double deepest = 0;
    for (const ContactReport& contact : scene->contacts()) deepest = std::max(deepest, -contact.gap_m);
    EXPECT_LT(deepest, 0.01);
    for (const BodyId id : scene->bodies()) {
        EXPECT_GT(scene->state(id).position_m.z, 0.2) << id;
        EXPECT_LT(std::abs(scene->state(id).position_m.x), 3) << id;
    }
}

TEST(Shapes, AnyNumberOfWorkersGivesTheSameBits) {
    Digest first;
    for (const int threads : {1, 2, 3}) {
        auto scene = pile(3);
        Workers workers(threads);
        run(*scene, 400, 2, workers);
        if (threads == 1) first = scene->digest();
        EXPECT_EQ(scene->digest(), first) << threads;
    }
}

TEST(Shapes, AreSavedAndLoaded) {
    auto scene = pile(2);
    Workers workers(2);
    for (int i = 0; i < 12; ++i) {
        run(*scene, 23, 2, workers);
        const auto other = loaded(saved(*scene), pile(0), workers);
        EXPECT_EQ(other->digest(), scene->digest());
        EXPECT_EQ(other->shape(2), scene->shape(2));
        ASSERT_EQ(other->contacts().size(), scene->contacts().size());
        run(*other, 30, 2, workers);
        run(*scene, 30, 2, workers);
        EXPECT_EQ(other->digest(), scene->digest()) << i;
        EXPECT_TRUE(std::ranges::equal(other->events(), scene->events()));
    }
}

TEST(Shapes, TouchEventsAndForcesCountBodiesNotPoints) {
    auto scene = scene_on_plane();
    need(scene->add_body({.id = 3, .position_m = {0, 0, 0.5}, .mass_kg = 2, .shape = box_shape({1, 1, 1}, 0)}));
    need(scene->add_body({.id = 1, .position_m = {0, 0, 1.75}, .mass_kg = 1, .shape = box_shape({0.5, 0.5, 0.5}, 0)}));
    Workers workers(1);
    int began = 0;
    for (int tick = 0; tick < 240; ++tick) {
        run(*scene, 1, 2, workers);
        for (const TouchEvent& event : scene->events()) began += event.began ? 1 : 100;
    }
    EXPECT_EQ(began, 2);
    ASSERT_EQ(scene->contacts().size(), 2u);
    const ContactReport &between = scene->contacts()[0], &below = scene->contacts()[1];
    EXPECT_EQ(between.touch, Touch(1, 3, false));
    EXPECT_NEAR(between.normal.z, -1, 1e-6);
    EXPECT_NEAR(between.normal_force_n, kGravity, 0.01 * kGravity);
    EXPECT_NEAR(below.normal_force_n, 3 * kGravity, 0.03 * kGravity);
    EXPECT_NEAR(scene->pressure(1), between.normal_force_n / 1.5, 1e-6);
    need(scene->remove_body(3));
    run(*scene, 1, 2, workers);
    EXPECT_EQ(scene->events().size(), 2u);
    EXPECT_FALSE(scene->events()[0].began);
}

TEST(Shapes, AreRefusedWhereTheyCannotBe) {
    const auto refused = [](Result<void> result, const std::string& why) {
        ASSERT_FALSE(result);
        EXPECT_NE(result.error().message().find(why), std::string::npos) << result.error().message();
    };
    const BodySpec cube{.id = 0, .position_m = {0, 0, 5}, .shape = box_shape({1, 1, 1}, 0.02)};
    Settings hash;
    hash.engine = EngineKind::Hash;
    refused(make_scene(hash)->add_body(cube), "the engine Hash has none");
    auto scene = scene_on_plane();
    refused(scene->add_body({.id = 0, .shape = BodyShape({0.5, 0.5, 0}, 0.1)}), "no solid");
    refused(scene->add_body({.id = 0, .shape = box_shape({1, 1, 1}, 0.6)}), "no solid");
    refused(scene->add_body({.id = 0, .position_m = {0, 0, -0.2}, .shape = box_shape({1, 1, 1}, 0)}), "deep in obstacle 0");
}

TEST(Shapes, ADeepOverlapEndsTheStepAndRestoresTheState) {
    auto scene = scene_on_plane();
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .shape = box_shape({1, 1, 1}, 0.02)}));
    need(scene->add_body({.id = 7, .position_m = {0, 0, 2.5}, .shape = box_shape({1, 1, 1}, 0.02)}));
    Workers workers(1);
    run(*scene, 10, 2, workers);
    const Digest before = scene->digest();
    BodyState state = scene->state(7);
    const Vec3 place = state.position_m;
    state.position_m = {0.1, 0, 0.8};
    need(scene->set_state(7, state));
    const auto report = scene->step(kTick, 2, workers);
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().problem.find("bodies 0 and 7 overlap by 0.7 m, more than 50 % of their radii together"), std::string::npos)
        << report.error().problem;
    state.position_m = place;
    need(scene->set_state(7, state));
    EXPECT_EQ(scene->digest(), before);
    run(*scene, 240, 2, workers);
    EXPECT_NEAR(scene->state(7).position_m.z, 1.5, 0.01);
}

}  // namespace
}  // namespace meld::physics
