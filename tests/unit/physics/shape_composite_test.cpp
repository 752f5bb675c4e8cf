// Composites of cubes, boxes, capsules and spheres against statics and mechanics, and for the same bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "physics/bodies/simd.h"
#include "physics/solver/engine.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics::shape_composites {
namespace {

const BodyShape kCube = box_shape({1, 1, 1}, 0.02), kSharp = box_shape({1, 1, 1}, 0);

// Cubes in a row along an axis, each connected with the one before.
void add_cubes(Scene& scene, BodyId first, int count, Vec3 where, Quat turn = {}, double mass = 1, const BodyShape& shape = kCube) {
    for (int i = 0; i < count; ++i) {
        const BodyId id = first + BodyId(i);
        need(scene.add_body(
            {.id = id, .position_m = where + rotate(turn, {double(i), 0, 0}), .orientation = turn, .mass_kg = mass, .shape = shape}));
        if (i > 0) need(scene.connect(id - 1, id));
    }
}

TEST(ShapeComposites, EightCubesHaveTheInertiaOfALargeOne) {
    const Quat turn = turn_of(0.8, {1, 2, 3});
    auto scene = make_scene(settings_with({}));
    BodyId id = 0;
    for (const double x : {-0.5, 0.5})
        for (const double y : {-0.5, 0.5})
            for (const double z : {-0.5, 0.5}) {
                need(scene->add_body({.id = id, .position_m = rotate(turn, {x, y, z}), .orientation = turn, .shape = kSharp}));
                if (id > 0) need(scene->connect(0, id));
                ++id;
            }
    // Three plates are a box of 1 by 2 by 3, and its own axes are turned.
    for (int i = 0; i < 3; ++i) {
        need(scene->add_body({.id = 10 + BodyId(i),
                              .position_m = Vec3{9, 0, 0} + rotate(turn, {0, 0, double(i)}),
                              .orientation = turn,
                              .mass_kg = 2,
                              .shape = box_shape({1, 2, 1}, 0)}));
        if (i > 0) need(scene->connect(9 + BodyId(i), 10 + BodyId(i)));
    }
    Workers workers(1);
    run(*scene, 1, 1, workers);
    const Symmetric large = scene->composite(0)->inertia_kg_m2;
    for (const double moment : {large.xx, large.yy, large.zz}) EXPECT_NEAR(moment, 8 * (4 + 4) / 12.0, 1e-5);
    for (const double product : {large.xy, large.xz, large.yz}) EXPECT_NEAR(product, 0, 1e-5);
    const Symmetric plates = scene->composite(10)->inertia_kg_m2;
    const Vec3 moments{6 * (4 + 9) / 12.0, 6 * (1 + 9) / 12.0, 6 * (1 + 4) / 12.0}, axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double expected[3] = {moments.x, moments.y, moments.z};
    for (int k = 0; k < 3; ++k) {
        const Vec3 axis = rotate(turn, axes[k]);
        EXPECT_LT(length(plates * axis - expected[k] * axis), 1e-5) << k;
    }
}

TEST(ShapeComposites, ACantileverOfCubesCarriesWhatStaticsSays) {
    for (const Quat& turn : {Quat{}, turn_of(0.7, {1, 2, -1}), turn_of(2.1, {-3, 1, 2})})
        for (const double rise : {0.0, 0.5}) {
            const int count = 10;
            const double mass = 0.7, slope = std::asin(rise);
            auto scene = make_scene(settings_with(rotate(turn, {0, 0, -kGravity})));
            const Quat along = product(turn, turn_of(-slope, {0, 1, 0}));
            const Vec3 root{3, -2, 8}, way = rotate(along, {1, 0, 0});
            need(scene->add_body({.id = 1000, .position_m = root, .orientation = along, .fixed = true, .shape = kCube}));
            add_cubes(*scene, 0, count, root + way, along, mass);
            need(scene->connect(1000, 0));
            scene->want_loads();
            Workers workers(1);
            run(*scene, 240, 2, workers);
            EXPECT_TRUE(need(scene->solve_loads(workers)).empty());
            for (int k = 0; k < count; ++k) {
                const ConnectionLoad at = k == 0 ? load(*scene, 1000, 0) : load(*scene, BodyId(k) - 1, BodyId(k));
                // The face is half a cube before the first cube that hangs on it.
                const double beyond = count - k, weight = beyond * mass * kGravity;
                EXPECT_NEAR(at.shear_n, weight * std::cos(slope), 1e-3 * weight) << k;
                EXPECT_NEAR(at.tension_n, -weight * rise, 1e-3 * weight) << k;
                EXPECT_NEAR(at.bending_nm, weight * std::cos(slope) * beyond / 2, 1e-3 * weight * beyond / 2) << k;
                EXPECT_NEAR(at.twist_nm, 0, 1e-3 * weight);
                EXPECT_LT(length(scene->state(BodyId(k)).position_m - (root + (k + 1.0) * way)), 1e-6) << k;
            }
        }
}

TEST(ShapeComposites, AConnectionSitsInTheMiddleOfWhatTouches) {
    // A brick lies half over the edge of another that is held, and a post stands on it; and a capsule and a ball hang under it.
    auto scene = make_scene();
    const BodyShape brick = box_shape({2, 1, 0.5}, 0.01), post = box_shape({0.4, 0.4, 3}, 0.01);
    need(scene->add_body({.id = 0, .position_m = {0, 0, 5}, .fixed = true, .shape = brick}));
    need(scene->add_body({.id = 1, .position_m = {1, 0, 5.5}, .mass_kg = 2, .shape = brick}));
    need(scene->add_body({.id = 2, .position_m = {1.5, 0.2, 7.25}, .mass_kg = 3, .shape = post}));
    need(scene->add_body({.id = 3,
                          .position_m = {1.9, 0, 5.05},
                          .orientation = turn_of(1.5707963267948966, {0, 1, 0}),
                          .mass_kg = 1,
                          .shape = capsule_shape(0.2, 0.8)}));
    need(scene->add_body({.id = 4, .position_m = {1.9, 0, 4.55}, .radius_m = 0.3, .mass_kg = 0.5}));
    for (const auto& [one, other] : {ConnectionPair{0, 1}, {1, 2}, {1, 3}, {3, 4}}) need(scene->connect(one, other));
    scene->want_loads();
    Workers workers(1);
    run(*scene, 2, 2, workers);
    need(scene->solve_loads(workers));
    // The faces of the bricks touch from 0 to 1.
    const double g = kGravity, all = 6.5 * g;
    EXPECT_NEAR(load(*scene, 0, 1).tension_n, -all, 1e-3 * all);
    EXPECT_NEAR(load(*scene, 0, 1).shear_n, 0, 1e-3 * all);
    const double about_y = g * (2 * 0.5 + 3 * 1.0 + 1.5 * 1.4), about_x = g * 3 * 0.2;
    EXPECT_NEAR(load(*scene, 0, 1).bending_nm, std::hypot(about_y, about_x), 1e-3 * about_y);
    EXPECT_NEAR(load(*scene, 1, 2).tension_n, -3 * g, 1e-3 * 3 * g);
    EXPECT_NEAR(load(*scene, 1, 2).bending_nm, 0, 1e-3 * g);
    // Under the brick the capsule lies from 1.7 to its edge at 2: the ball hangs 0.05 beside the middle of that.
    EXPECT_NEAR(load(*scene, 1, 3).tension_n, 1.5 * g, 1e-3 * g);
    EXPECT_NEAR(load(*scene, 1, 3).bending_nm, 1.5 * g * 0.05, 2e-2 * g);
    EXPECT_NEAR(load(*scene, 3, 4).tension_n, 0.5 * g, 1e-3 * g);
    EXPECT_NEAR(load(*scene, 3, 4).torque_nm(), 0, 1e-3 * g);
}

TEST(ShapeComposites, ABeamOnTwoSupportsCarriesAWeight) {
    // Eleven cubes lie with their ends on two boxes, and a heavy cube or ball stands on their middle.
    for (const bool ball : {false, true}) {
        auto scene = make_scene();
        for (const double x : {0.0, 10.0}) need(scene->add_obstacle(Box{.centre = {x, 0, -0.5}, .size_m = {1, 1, 1}}, 0));
        add_cubes(*scene, 0, 11, {0, 0, 0.5});
        BodySpec weight{.id = 100, .position_m = {5, 0, 1.5}, .mass_kg = 8};
        if (!ball) weight.shape = kCube;
        need(scene->add_body(weight));
        scene->want_loads();
        Workers workers(1);
        run(*scene, 120, 4, workers);
        need(scene->solve_loads(workers));
        run(*scene, 60, 4, workers);
        need(scene->solve_loads(workers));
        EXPECT_EQ(scene->composite(5)->bodies, 11u);
        EXPECT_NEAR(scene->state(5).position_m.z, 0.5, 2e-3);
        EXPECT_NEAR(scene->state(100).position_m.z, 1.5, 4e-3);
        // Half of all rests on each end; next to the middle, 5 cubes and half the middle one are within.
        const double half = (11 + 8) * kGravity / 2;
        EXPECT_NEAR(load(*scene, 4, 5).shear_n, half - 5 * kGravity, 0.02 * half) << ball;
        // The supports push somewhere within the end cubes: the torque at 4.5 is known as exactly.
        const double torque = half * 4.5 - 5 * kGravity * 2.5;
        EXPECT_NEAR(load(*scene, 4, 5).bending_nm, torque, 0.12 * torque) << ball;
        EXPECT_NEAR(load(*scene, 4, 5).bending_nm, load(*scene, 5, 6).bending_nm, 0.03 * torque) << ball;
    }
}

TEST(ShapeComposites, WhatHitsAWeightOnACantileverGoesThroughItsRoot) {
    // Contacts that press and then bounce in one substep carry both.
    for (const double restitution : {0.0, 0.5})
        for (const int substeps : {2, 4}) {
            auto scene = make_scene(settings_with({0, 0, -kGravity}, 0));
            const auto material = need(scene->add_material({.friction = 0, .restitution = float(restitution)}));
            need(scene->add_body({.id = 1000, .position_m = {-1, 0, 0}, .fixed = true, .shape = kCube}));
            add_cubes(*scene, 0, 5, {0, 0, 0});
            need(scene->connect(1000, 0));
            for (const BodyId i : {0u, 1u})
                need(scene->add_body({.id = 10 + i,
                                      .position_m = {4, 0, 1 + 1.3 * i},
                                      .linear_velocity_m_s = {0, 0, -3.0 * i},
                                      .mass_kg = 20,
                                      .material = material,
                                      .shape = kCube}));
            scene->want_loads();
            Workers workers(1);
            double momentum = 0;
            for (int tick = 0; tick < 60; ++tick) {
                run(*scene, 1, substeps, workers);
                need(scene->solve_loads(workers));
                momentum += load(*scene, 1000, 0).shear_n * kTick;
            }
            const double after = 20 * (scene->state(10).linear_velocity_m_s.z + scene->state(11).linear_velocity_m_s.z);
            EXPECT_NEAR(momentum, (5 + 40) * kGravity * 60 * kTick + after + 20 * 3, 0.01) << restitution << ", " << substeps;
        }
}

TEST(ShapeComposites, ABeamOnTwoEdgesHasExactTorques) {
    // Capsules across it are the supports, so their places are known; without friction they do not push along it.
    auto scene = make_scene();
    const auto smooth = need(scene->add_material({.friction = 0}));
    const Quat across = turn_of(1.5707963267948966, {1, 0, 0});
    for (const BodyId i : {0u, 1u})
        need(scene->add_body({.id = 50 + i,
                              .position_m = {10.0 * i, 0, -0.5},
                              .orientation = across,
                              .material = smooth,
                              .fixed = true,
                              .shape = capsule_shape(0.5, 3)}));
    add_cubes(*scene, 0, 11, {0, 0, 0.5});
    need(scene->add_body({.id = 100, .position_m = {3, 0, 1.5}, .mass_kg = 8, .shape = kCube}));
    scene->want_loads();
    Workers workers(1);
    run(*scene, 240, 4, workers);
    need(scene->solve_loads(workers));
    run(*scene, 60, 4, workers);
    need(scene->solve_loads(workers));
    const double left = kGravity * (5.5 + 8 * 0.7), right = kGravity * (5.5 + 8 * 0.3);
    for (int k = 0; k < 10; ++k) {
        const double at = k + 0.5, shear = k < 3 ? left - (k + 1) * kGravity : 0;
        const double torque =
            k < 3 ? left * at - (k + 1) * kGravity * (at - 0.5 * k) : right * (10 - at) - (10 - k) * kGravity * 0.5 * (10 - k);
        const ConnectionLoad here = load(*scene, BodyId(k), BodyId(k) + 1);
        EXPECT_NEAR(here.bending_nm, std::abs(torque), 1e-3 * left * 3) << k;
        if (k < 3) {
            EXPECT_NEAR(here.shear_n, shear, 1e-3 * left) << k;
        }
    }
}

TEST(ShapeComposites, SpinFreelyAndKeepAngularMomentum) {
    auto scene = make_scene(settings_with({}));
    add_cubes(*scene, 0, 4, {0, 0, 0});
    need(scene->add_body({.id = 4, .position_m = {0, 0.75, 0.3}, .mass_kg = 2, .shape = box_shape({0.5, 0.5, 2}, 0.01)}));
    need(scene->add_body({.id = 5, .position_m = {3, -1, 0}, .orientation = turn_of(0.4, {0, 0, 1}), .shape = capsule_shape(0.4, 2)}));
    need(scene->add_body({.id = 6, .position_m = {1, 0, 1}}));
    for (const BodyId body : {4u, 6u}) need(scene->connect(body, body == 4 ? 0 : 1));
    need(scene->connect(3, 5));
    BodyState state = scene->state(0);
    state.linear_velocity_m_s = {3, -2, 1}, state.angular_velocity_rad_s = {5, 7, -4};
    need(scene->set_state(0, state));
    Workers workers(1);
    run(*scene, 1, 2, workers);
    const Vec3 momentum = scene->momentum(), angular = scene->angular_momentum();
    scene->want_loads();
    run(*scene, 480, 2, workers);
    EXPECT_LT(length(scene->momentum() - momentum), 1e-5);
    EXPECT_LT(length(scene->angular_momentum() - angular), 1e-4 * length(angular));
    EXPECT_NEAR(length(scene->state(0).position_m - scene->state(5).position_m), std::hypot(3, 1), 1e-6);
    // The members of a tree pull on each other as their motion says: here on the capsule, by Newton and Euler.
    const auto moment = [&](BodyId body) {
        const BodyState now = scene->state(body);
        const Vec3 inertia = capsule_shape(0.4, 2).inertia_per_kg_m2(),
                   own = rotate(conjugate(now.orientation), now.angular_velocity_rad_s);
        return rotate(now.orientation, {inertia.x * own.x, inertia.y * own.y, inertia.z * own.z});
    };
    need(scene->solve_loads(workers));
    const BodyState before = scene->state(5);
    const Vec3 spin_before = moment(5);
    const Vec3 face = scene->state(3).position_m + rotate(scene->state(3).orientation, {0, -0.5, 0});
    run(*scene, 1, 8, workers);
    need(scene->solve_loads(workers));
    const Vec3 force = (1 / kTick) * (scene->state(5).linear_velocity_m_s - before.linear_velocity_m_s);
    const Vec3 torque = (1 / kTick) * (moment(5) - spin_before) - cross(face - before.position_m, force);
    const ConnectionLoad found = load(*scene, 3, 5);
    EXPECT_NEAR(std::hypot(found.tension_n, found.shear_n), length(force), 0.02 * length(force));
    EXPECT_NEAR(found.torque_nm(), length(torque), 0.05 * length(torque) + 0.02 * length(force));
}

TEST(ShapeComposites, MergeAndSplitKeepMomentumAndAngularMomentum) {
    auto scene = make_scene(settings_with({}));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> some(-1, 1);
    const auto vector = [&] { return Vec3{some(random), some(random), some(random)}; };
    const auto turn = [&] {
        const double angle = some(random);
        return turn_of(angle, vector());
    };
    const BodyShape shapes[] = {kCube, box_shape({0.5, 1, 0.7}, 0.02), capsule_shape(0.3, 1), cylinder_shape(0.4, 0.8, 0.02)};
    for (BodyId id = 0; id < 30; ++id) {
        BodySpec spec{.id = id,
                      .position_m = {1.8 * (id % 3), 1.8 * (id / 3 % 3), 1.8 * (id / 9)},
                      .orientation = turn(),
                      .linear_velocity_m_s = 0.3 * vector(),
                      .angular_velocity_rad_s = 2 * vector(),
                      .mass_kg = 1 + 0.5 * some(random)};
        if (id % 5 != 4) spec.shape = shapes[id % 5];
        need(scene->add_body(spec));
    }
    Workers workers(1);
    run(*scene, 1, 2, workers);
    const Vec3 momentum = scene->momentum(), angular = scene->angular_momentum();
    for (int round = 0; round < 60; ++round) {
        const auto a = BodyId(random() % 30), b = BodyId(random() % 30);
        if (a == b) continue;
        need(scene->connected(a, b) ? scene->release(a, b) : scene->connect(a, b));
        const double energy = scene->kinetic_energy_j();
        run(*scene, 1, 2, workers);
        EXPECT_LT(length(scene->momentum() - momentum), 2e-5) << round;
        EXPECT_LT(length(scene->angular_momentum() - angular), 4e-4) << round;
        EXPECT_LT(scene->kinetic_energy_j(), energy * (1 + 1e-4)) << round;
    }
}

TEST(ShapeComposites, ThreeCubesMoveAsOneBar) {
    // Of sharp cubes, thrown onto a plane with friction and restitution: until the third blow, the same as a bar. And a bar slides alike.
    const auto build = [](bool whole, bool slide) {
        auto scene = make_scene();
        const auto material = need(scene->add_material({.friction = 0.3f, .restitution = slide ? 0.0f : 0.5f}));
        need(scene->add_obstacle(Plane{}, material));
        const Quat turn = slide ? Quat{} : turn_of(0.5, {1, 2, 0.5});
        const Vec3 centre = slide ? Vec3{0, 0, 0.5} : Vec3{0, 0, 2.5}, velocity{2, 0.5, 0};
        if (whole) {
            need(scene->add_body({.id = 1,
                                  .position_m = centre,
                                  .orientation = turn,
                                  .linear_velocity_m_s = velocity,
                                  .mass_kg = 3,
                                  .material = material,
                                  .shape = box_shape({3, 1, 1}, 0)}));
            return scene;
        }
        for (const BodyId i : {0u, 1u, 2u})
            need(scene->add_body({.id = i,
                                  .position_m = centre + rotate(turn, {double(i) - 1, 0, 0}),
                                  .orientation = turn,
                                  .linear_velocity_m_s = velocity,
                                  .material = material,
                                  .shape = kSharp}));
        need(scene->connect(0, 1)), need(scene->connect(1, 2));
        return scene;
    };
    Workers workers(1);
    for (const bool slide : {false, true}) {
        auto bar = build(true, slide), cubes = build(false, slide);
        const int ticks = slide ? 240 : 190;
        for (int tick = 0; tick < ticks; ++tick) {
            run(*bar, 1, 4, workers), run(*cubes, 1, 4, workers);
            const BodyState one = bar->state(1), other = cubes->state(1);
            ASSERT_LT(length(one.position_m - other.position_m), slide ? 2e-3 : 0.02) << tick;
            ASSERT_LT(length(one.linear_velocity_m_s - other.linear_velocity_m_s), slide ? 0.01 : 0.06) << tick;
            ASSERT_LT(length(one.angular_velocity_rad_s - other.angular_velocity_rad_s), slide ? 0.01 : 0.1) << tick;
        }
        if (slide) {
            EXPECT_NEAR(cubes->state(1).position_m.x, (4 + 0.25) / (2 * 0.3 * kGravity) * 2 / std::hypot(2, 0.5), 0.01);
        } else {
            EXPECT_GT(length(bar->state(1).angular_velocity_rad_s), 0.5);
        }
    }
}

TEST(ShapeComposites, APlankTipsWhenItsMiddleIsOverTheEdge) {
    for (const double beyond : {-0.2, 0.2}) {
        auto scene = make_scene();
        need(scene->add_obstacle(Box{.centre = {-5, 0, -0.5}, .size_m = {10, 4, 1}}, 0));
        // Its middle is that far beyond the edge.
        add_cubes(*scene, 0, 7, {beyond - 3, 0, 0.5});
        Workers workers(1);
        run(*scene, 480, 4, workers);
        if (beyond < 0) {
            EXPECT_NEAR(scene->state(6).position_m.z, 0.5, 2e-3);
            EXPECT_TRUE(scene->asleep(3));
        } else {
            EXPECT_LT(scene->state(6).position_m.z, -3);
        }
    }
}

TEST(ShapeComposites, CollideAsTheirWholeMasses) {
    // Head on, with restitution 1, through the line of both centres: three cubes hit one that is free.
    auto scene = make_scene(settings_with({}));
    const auto material = need(scene->add_material({.friction = 0, .restitution = 1}));
    for (const BodyId i : {0u, 1u, 2u})
        need(scene->add_body(
            {.id = i, .position_m = {double(i), 0, 0}, .linear_velocity_m_s = {2, 0, 0}, .material = material, .shape = kCube}));
    need(scene->connect(0, 1)), need(scene->connect(1, 2));
    need(scene->add_body({.id = 3, .position_m = {3.5, 0, 0}, .material = material, .shape = kCube}));
    Workers workers(1);
    run(*scene, 120, 2, workers);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 2 * (3 - 1) / 4.0, 1e-3);
    EXPECT_NEAR(scene->state(3).linear_velocity_m_s.x, 2 * 2 * 3 / 4.0, 1e-3);
    EXPECT_LT(length(scene->state(0).angular_velocity_rad_s), 1e-3);
}

TEST(ShapeComposites, TouchesEndWithinThemAndBeginAgain) {
    auto scene = scene_on_plane();
    for (const BodyId i : {0u, 1u}) need(scene->add_body({.id = i, .position_m = {0, 0, 0.5 + i}, .shape = kCube}));
    Workers workers(1);
    const auto events = [&] {
        std::vector<std::pair<Touch, bool>> found;
        for (const TouchEvent& e : scene->events()) found.emplace_back(e.touch, e.began);
        return found;
    };
    const Touch both{0, 1, false};
    run(*scene, 1, 2, workers);
    EXPECT_TRUE(std::ranges::count(events(), std::pair(both, true)) == 1);
    need(scene->connect(0, 1));
    run(*scene, 1, 2, workers);
    EXPECT_EQ(events(), (std::vector<std::pair<Touch, bool>>{{both, false}}));
    EXPECT_TRUE(scene->lasts(both));
    EXPECT_EQ(scene->contacts().size(), 1u);
    EXPECT_NEAR(scene->contacts()[0].normal_force_n, 2 * kGravity, 0.05 * kGravity);
    run(*scene, 200, 2, workers);
    EXPECT_TRUE(scene->asleep(0) && scene->asleep(1));
    need(scene->release(0, 1));
    run(*scene, 1, 2, workers);
    EXPECT_EQ(events(), (std::vector<std::pair<Touch, bool>>{{both, true}}));
    EXPECT_NEAR(scene->state(1).position_m.z, 1.5, 2e-3);
}

TEST(ShapeComposites, AFixedCubeCarriesThem) {
    auto scene = scene_on_plane();
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .linear_velocity_m_s = {1, 0, 0}, .fixed = true, .shape = kCube}));
    for (const BodyId i : {1u, 2u}) need(scene->add_body({.id = i, .position_m = {0, 0, 0.5 + i}, .shape = kCube}));
    need(scene->connect(0, 1)), need(scene->connect(1, 2));
    // It pushes a free cube.
    need(scene->add_body({.id = 3, .position_m = {1.2, 0, 0.5}, .shape = kCube}));
    Workers workers(1);
    run(*scene, 240, 2, workers);
    EXPECT_NEAR(scene->state(2).position_m.x, 1, 1e-3);
    EXPECT_NEAR(scene->state(2).position_m.z, 2.5, 1e-6);
    EXPECT_NEAR(scene->state(3).position_m.x, 2, 0.01);
}

// Everything at once: bodies of all shapes, that connect and let go at random where they are near, break, bounce, and sleep.
struct Crowd {
    std::vector<Digest> digests;
    std::vector<ConnectionLoad> loads;
    std::size_t broken = 0, composites = 0;
    bool operator==(const Crowd&) const = default;
};
Crowd run_crowd(int threads, int save_at = -1, SolverMode mode = SolverMode::Soft) {
    Settings settings;
    settings.max_overlap_share = 2;
    if (mode == SolverMode::Pgs) settings.solver = SolverSettings::pgs20();
    const auto build = [&] {
        auto scene = scene_on_plane(settings);
        const auto bouncy = need(scene->add_material({.friction = 0.3f, .restitution = 0.4f}));
        need(scene->add_obstacle(Box{.centre = {4, 4, -0.1}, .size_m = {3, 2, 1}, .orientation = turn_of(0.4, {0, 0, 1})}, bouncy));
        scene->want_loads();
        return scene;
    };
    auto scene = build();
    std::mt19937 random(17);
    std::uniform_real_distribution<double> some(-1, 1);
    const auto turn = [&] {
        const double angle = some(random);
        return turn_of(angle, {some(random), some(random), 1});
    };
    const BodyShape shapes[] = {kCube, box_shape({0.6, 1, 0.7}, 0.02), capsule_shape(0.3, 1.1), cylinder_shape(0.4, 0.8, 0.02)};
    const BodyId bodies = 400;
    for (BodyId id = 0; id < bodies; ++id) {
        BodySpec spec{.id = id,
                      .position_m = Vec3{1.3 * (id % 8), 1.3 * (id / 8 % 8), 1 + 1.3 * (id / 64)} +
                                    0.1 * Vec3{some(random), some(random), some(random)},
                      .orientation = turn(),
                      .linear_velocity_m_s = {some(random), some(random), some(random)},
                      .material = std::uint8_t(id % 3 == 0 ? 1 : 0),
                      .fixed = id % 97 == 96};
        if (id % 5 != 4)
            spec.shape = shapes[id % 5];
        else
            spec.radius_m = 0.45;
        need(scene->add_body(spec));
    }
    // A long beam over several blocks, of cubes and balls.
    for (BodyId i = 0; i < 40; ++i) {
        BodySpec spec{.id = 2000 + i, .position_m = {-14 + double(i), 5, 12}};
        if (i % 4 != 0) spec.shape = kCube;
        need(scene->add_body(spec));
        if (i > 0) need(scene->connect(1999 + i, 2000 + i));
    }
    for (BodyId id = 0; id < bodies; id += 3) need(scene->set_breaking(id, {.force_n = 30, .torque_nm = 8}));
    for (BodyId id = 2000; id < 2040; ++id) need(scene->set_breaking(id, {.torque_nm = 300}));
    Workers workers(threads);
    Crowd crowd;
    std::set<ConnectionPair> edges;
    for (int tick = 0; tick < 60; ++tick) {
        for (int i = 0; i < 20; ++i) {
            const auto a = BodyId(random() % bodies);
            if (!edges.empty() && random() % 5 < 2) {
                const auto [one, other] = *std::next(edges.begin(), static_cast<long>(random() % edges.size()));
                need(scene->release(one, other));
                edges.erase({one, other});
                continue;
            }
            for (BodyId b = a + 1; b < bodies; ++b)
                if (scene->nearer(a, b, 0.4)) {
                    need(scene->connect(b, a));
                    edges.insert({a, b});
                    break;
                }
        }
        run(*scene, 1, 2, workers);
        if (tick % 2 == 1) {
            const std::vector<ConnectionPair> broken = need(scene->solve_loads(workers));
            for (const ConnectionPair& pair : broken) edges.erase(pair);
            crowd.broken += broken.size();
        }
        for (const CarriedLoad& each : scene->loads()) crowd.loads.push_back(each.load);
        crowd.digests.push_back(scene->digest());
        crowd.composites = std::max(crowd.composites, scene->world().composites.all().size());
        if (tick != save_at) continue;
        auto other = loaded(saved(*scene), build(), workers);
        EXPECT_EQ(other->digest(), scene->digest());
        scene = std::move(other);
    }
    return crowd;
}

TEST(ShapeComposites, SameBitsForWorkersInstructionsAndSnapshots) {
    const Crowd one = run_crowd(1);
    EXPECT_NE(one.digests[10], one.digests[11]);
    EXPECT_GT(one.loads.size(), 1000u);
    EXPECT_GT(one.broken, 3u);
    EXPECT_GT(one.composites, 20u);
    EXPECT_EQ(run_crowd(2), one);
    for (const int tick : {0, 16, 41}) EXPECT_EQ(run_crowd(2, tick), one) << tick;
    const SimdLevel best = simd_level();
    set_simd_level(SimdLevel::Baseline);
    EXPECT_EQ(run_crowd(1), one);
    set_simd_level(best);
    const Crowd cold = run_crowd(1, -1, SolverMode::Pgs);
    EXPECT_EQ(run_crowd(2, -1, SolverMode::Pgs), cold);
}

}  // namespace
}  // namespace meld::physics::shape_composites
