// Obstacles that move: questions go into the frame of the obstacle, in which it stands still, and the answers back into the world.
#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/collision/obstacles.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

Pose into_frame(const MovingFrame& frame, const Pose& pose) {
    Pose own{frame.into(pose.centre), {}};
    for (std::size_t k = 0; k < 3; ++k) own.axes[k] = frame.turned_into(pose.axes[k]);
    return own;
}

// Points are seen from the body.
void out_of_frame(const MovingFrame& frame, Manifold& found) {
    if (found.count == 0) return;
    found.normal = frame.turned_out_of(found.normal);
    for (int p = 0; p < found.count; ++p) {
        Vec3& at = found.points[static_cast<std::size_t>(p)].at;
        at = frame.turned_out_of(at);
    }
}

// A ball around an obstacle. Below terrain is ground to any depth, but what is met is its surface.
struct Ball {
    Vec3 centre;
    double radius_m;
};
Ball ball_around(const Shape& shape, Vec3 low, Vec3 high) {
    if (const Plane* plane = std::get_if<Plane>(&shape)) return {plane->offset_m * plane->normal, std::numeric_limits<double>::infinity()};
    if (const Terrain* terrain = std::get_if<Terrain>(&shape)) low.z = terrain->origin.z + *std::ranges::min_element(terrain->heights_m);
    const Vec3 centre = 0.5 * (low + high);
    const bool surface = std::holds_alternative<Terrain>(shape) || std::holds_alternative<Mesh>(shape);
    return {centre, surface ? length(high - centre) : high.x - centre.x};
}

}  // namespace

void Obstacles::set_motion(std::size_t obstacle, const PrescribedMotion& motion) {
    MELD_EXPECT(obstacle < count() && entries_[obstacle].frame == 0, "obstacle {} of {}", obstacle, count());
    Entry& entry = entries_[obstacle];
    const Ball ball = ball_around(entry.shape, entry.low, entry.high);
    frames_.emplace_back(motion, ball.centre, ball.radius_m);
    entry.frame = frames_.size();
}

Vec3 Obstacles::velocity_at(std::size_t obstacle, Vec3 point, Vec3 normal) const {
    const Entry& entry = entries_[obstacle];
    const Vec3 belt = entry.belt == 0 ? Vec3{} : belts_[entry.belt - 1];
    if (!moves(obstacle)) return cross(belt, normal);
    const MovingFrame& own = frame(obstacle);
    return own.velocity_at(point) + cross(own.turned_out_of(belt), normal);
}

int Obstacles::collide(int worker, std::size_t obstacle, Vec3 centre, double radius_m, double reach_m,
                       std::array<SurfaceContact, kMaxSurfaceContacts>& contacts) {
    if (!moves(obstacle)) return collide_own(worker, obstacle, centre, radius_m, reach_m, contacts);
    const MovingFrame& own = frame(obstacle);
    const int found = collide_own(worker, obstacle, own.into(centre), radius_m, reach_m, contacts);
    for (int c = 0; c < found; ++c) {
        Vec3& normal = contacts[static_cast<std::size_t>(c)].normal;
        normal = own.turned_out_of(normal);
    }
    return found;
}

std::optional<SurfaceContact> Obstacles::meet(std::size_t obstacle, Vec3 centre, double radius_m, Vec3 path,
                                              std::span<const SurfaceContact> touched) const {
    if (!moves(obstacle)) return meet_own(entries_[obstacle], centre, radius_m, path, touched);
    const MovingFrame& own = frame(obstacle);
    std::array<SurfaceContact, kMaxSurfaceContacts> seen;
    MELD_EXPECT(touched.size() <= seen.size(), "{} contacts", touched.size());
    for (std::size_t c = 0; c < touched.size(); ++c) seen[c] = {own.turned_into(touched[c].normal), touched[c].gap_m};
    auto met = meet_own(entries_[obstacle], own.into(centre), radius_m, own.turned_into(path), std::span(seen).first(touched.size()));
    if (met) met->normal = own.turned_out_of(met->normal);
    return met;
}

std::optional<double> Obstacles::first_on(std::size_t obstacle, const Ray& ray) const {
    if (!moves(obstacle)) return first_on_own(entries_[obstacle], ray);
    const MovingFrame& own = frame(obstacle);
    return first_on_own(entries_[obstacle], {own.into(ray.from), own.turned_into(ray.way)});
}

void Obstacles::collide_solid(std::size_t obstacle, std::size_t solid, const Core& core, const Pose& pose, double reach_m, AxisHint& hint,
                              Manifold& found) const {
    if (!moves(obstacle)) return collide_solid_own(entries_[obstacle], solid, core, pose, reach_m, hint, found);
    const MovingFrame& own = frame(obstacle);
    collide_solid_own(entries_[obstacle], solid, core, into_frame(own, pose), reach_m, hint, found);
    out_of_frame(own, found);
}

int Obstacles::collide_shape(std::size_t obstacle, const Core& core, const Pose& pose, double reach_m, AxisHint& hint,
                             std::array<Manifold, kMaxSurfaceContacts>& found) const {
    if (!moves(obstacle)) return collide_shape_own(entries_[obstacle], core, pose, reach_m, hint, found);
    const MovingFrame& own = frame(obstacle);
    const int count = collide_shape_own(entries_[obstacle], core, into_frame(own, pose), reach_m, hint, found);
    for (int m = 0; m < count; ++m) out_of_frame(own, found[static_cast<std::size_t>(m)]);
    return count;
}

}  // namespace meld::physics
