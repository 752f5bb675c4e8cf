#include "runtime/world/description/motions.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>

#include "runtime/world/shapes/surface.h"

namespace meld::world {

namespace {

constexpr double kDegree = std::numbers::pi / 180;

physics::Vec3 times_unit(double unit, const Vec3& v) { return {unit * v[0], unit * v[1], unit * v[2]}; }

Vec3 middle_of_terrain(const ObstacleOptions& o) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    double low = kFar, high = -kFar;
    for (const std::vector<double>& row : o.heights)
        for (const double height : row) low = std::min(low, height), high = std::max(high, height);
    const auto half = [&](std::size_t points) { return o.cell * static_cast<double>(points - 1) / 2; };
    return {o.centre[0] + half(o.heights[0].size()), o.centre[1] + half(o.heights.size()), o.centre[2] + (low + high) / 2};
}

Vec3 middle_of_mesh(const ObstacleOptions& o) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    const std::optional<model::Triangles> surface = world::surface(o.shape);
    if (!surface) return {};
    Vec3 low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
    for (const Vec3& point : surface->points)
        for (std::size_t i = 0; i < 3; ++i) low[i] = std::min(low[i], point[i]), high[i] = std::max(high[i], point[i]);
    return {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2};
}

}  // namespace

physics::PrescribedMotion motion_of(const PrescribedOptions& motion, double diameter) {
    physics::PrescribedMotion made{.swing_m = times_unit(diameter, motion.swing.swing),
                                   .tilt_rad = times_unit(kDegree, motion.swing.tilt),
                                   .frequency_hz = motion.swing.frequency,
                                   .phase_rad = kDegree * motion.swing.phase,
                                   .spin_rad_s = times_unit(1, motion.spin)};
    if (motion.pivot) made.pivot_m = times_unit(diameter, *motion.pivot);
    return made;
}

physics::PrescribedMotion motion_of(const ObstacleOptions& obstacle, double diameter) {
    physics::PrescribedMotion motion = motion_of(obstacle.motion, diameter);
    motion.pivot_m = times_unit(diameter, obstacle.motion.pivot.value_or(pivot_of(obstacle)));
    return motion;
}

Vec3 pivot_of(const ObstacleOptions& o) {
    if (o.kind == "terrain") return middle_of_terrain(o);
    if (o.kind == "mesh") return middle_of_mesh(o);
    if (o.kind != "plane" || o.form.compound) return o.centre;
    const physics::Vec3 normal{o.normal[0], o.normal[1], o.normal[2]};
    const double share = o.offset / dot(normal, normal);
    return {share * normal.x, share * normal.y, share * normal.z};
}

double end_of_tick_s(const World& world, std::int64_t tick) { return static_cast<double>(tick) * world.physics.steps * world.physics.step; }

}  // namespace meld::world
