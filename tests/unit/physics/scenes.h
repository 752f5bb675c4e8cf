// Scenes that several tests use.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "physics/scene/scene.h"

namespace meld::physics {

inline constexpr double kTick = 1.0 / 240;
inline constexpr double kGravity = 9.81;  // m/s², as Settings has it.

template <class T>
T need(Result<T> result) {
    EXPECT_TRUE(result) << result.error().message();
    return std::move(result).value_or(T{});
}
inline void need(const Result<void>& result) { EXPECT_TRUE(result) << result.error().message(); }

inline Settings settings_with(Vec3 gravity, int sleep_ticks = 30) {
    Settings settings;
    settings.gravity_m_s2 = gravity;
    settings.sleep_ticks = sleep_ticks;
    return settings;
}

// By this angle about an axis.
inline Quat turn_of(double angle, Vec3 axis) {
    const Vec3 unit = (1 / length(axis)) * axis;
    return {std::cos(angle / 2), std::sin(angle / 2) * unit.x, std::sin(angle / 2) * unit.y, std::sin(angle / 2) * unit.z};
}

inline std::unique_ptr<Scene> make_scene(const Settings& settings = {}) {
    auto scene = Scene::make(settings);
    EXPECT_TRUE(scene) << scene.error().message();
    return std::move(*scene);
}

inline std::unique_ptr<Scene> scene_on_plane(const Settings& settings = {}) {
    auto scene = make_scene(settings);
    need(scene->add_obstacle(Plane{}, 0));
    return scene;
}

// A cube of side^3 balls on the lattice of this spacing, the lowest touching the plane z = 0; numbered with x fastest.
inline void add_cube(Scene& scene, int side, double spacing = 1, Vec3 corner = {0, 0, 0.5}) {
    BodyId id = 0;
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
                need(scene.add_body({.id = id++, .position_m = corner + spacing * Vec3{double(x), double(y), double(z)}}));
}

// 125 bodies that fly towards a point, turning. Each gets its shape from change(spec).
template <class Change>
void add_implosion(Scene& scene, unsigned seed, const Change& change) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> speed(-1, 1);
    BodyId id = 0;
    for (int x = 0; x < 5; ++x)
        for (int y = 0; y < 5; ++y)
            for (int z = 0; z < 5; ++z, ++id) {
                const Vec3 at{1.6 * x - 3.2, 1.6 * y - 3.2, 1.6 * z - 3.2};
                BodySpec spec{.id = id, .position_m = at, .linear_velocity_m_s = -0.5 * at};
                spec.angular_velocity_rad_s = {speed(random), speed(random), speed(random)};
                change(spec);
                need(scene.add_body(spec));
            }
}

// Lets such bodies collide for two seconds without gravity: momentum and angular momentum stay, energy falls and never rises.
inline void expect_kept_momentum(Scene& scene) {
    const Vec3 momentum = scene.momentum(), angular = scene.angular_momentum();
    const double energy = scene.kinetic_energy_j();
    Workers workers(2);
    double most = energy;
    for (int tick = 0; tick < 480; ++tick) {
        need(scene.step(kTick, 2, workers));
        most = std::max(most, scene.kinetic_energy_j());
    }
    EXPECT_LT(scene.kinetic_energy_j(), 0.7 * energy);
    EXPECT_LT(most, 1.01 * energy);
    EXPECT_LT(length(scene.momentum() - momentum), 1e-3);
    // Points lie midway between the surfaces, so angular momentum is kept, too.
    EXPECT_LT(length(scene.angular_momentum() - angular), 0.01 * 125);
}

// A walled box into which so many layers of bodies fall, turned at random. Each gets its shape from change(spec).
template <class Change>
std::unique_ptr<Scene> walled_pile(int layers, const Change& change) {
    auto scene = scene_on_plane();
    for (const Vec3 side : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}}) need(scene->add_obstacle(Plane{side, -3}, 0));
    need(scene->add_obstacle(Box{{0, 0, 0.5}, {1, 1, 1}, {std::cos(0.3), 0, 0, std::sin(0.3)}}, 0));
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    BodyId id = 0;
    for (int z = 0; z < layers; ++z)
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 4; ++x, ++id) {
                Quat q{normal(random), normal(random), normal(random), normal(random)};
                const double n = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
                BodySpec spec{.id = id, .position_m = {1.4 * x - 2.1, 1.4 * y - 2.1, 2.5 + 1.5 * z}};
                spec.orientation = {q.w / n, q.x / n, q.y / n, q.z / n};
                change(spec);
                need(scene->add_body(spec));
            }
    return scene;
}

// 40 chains of five balls each that fall on each other, held by joints like this one.
inline void add_falling_chains(Scene& scene, JointSpec joint = {}) {
    BodyId id = 0;
    for (int c = 0; c < 40; ++c)
        for (int i = 0; i < 5; ++i, ++id) {
            const Vec3 at{1.0 * i + 0.1 * (c % 3), 1.2 * (c % 8), 1 + 1.1 * (c / 8)};
            need(scene.add_body({.id = id, .position_m = at}));
            if (i == 0) continue;
            joint.first = id - 1, joint.second = id, joint.anchor_m = at - Vec3{0.5, 0, 0}, joint.axis = {0, 1, 0.2 * (c % 2)};
            need(scene.add_joint(joint));
        }
}

// Balls of several sizes thrown into a box in space without overlapping much: on a jittered lattice.
inline void add_cloud(Scene& scene, int side, double spacing, unsigned seed, double height = 2) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2), radius(0.3, 0.5), speed(-2, 2);
    BodyId id = 0;
    for (int z = 0; z < side; ++z)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const double r = radius(random);
                need(scene.add_body(
                    {.id = id++,
                     .position_m = {spacing * x + jitter(random), spacing * y + jitter(random), height + spacing * z + jitter(random)},
                     .linear_velocity_m_s = {speed(random), speed(random), speed(random)},
                     .angular_velocity_rad_s = {speed(random), speed(random), speed(random)},
                     .radius_m = r,
                     .mass_kg = 8 * r * r * r}));
            }
}

// Steps, and fails the test at the first error.
inline void run(Scene& scene, int ticks, int substeps, Workers& workers) {
    for (int tick = 0; tick < ticks; ++tick) {
        const auto report = scene.step(kTick, substeps, workers);
        ASSERT_TRUE(report) << report.error().message();
    }
}

inline ConnectionLoad load(const Scene& scene, BodyId one, BodyId other) {
    const auto found = scene.load(one, other);
    EXPECT_TRUE(found) << one << " and " << other;
    return found.value_or(ConnectionLoad{});
}

inline double speed(const Scene& scene, BodyId body) { return length(scene.state(body).linear_velocity_m_s); }

}  // namespace meld::physics
