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
