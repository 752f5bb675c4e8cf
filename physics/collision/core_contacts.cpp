#include "physics/collision/core_contacts.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "physics/collision/box_contacts.h"
#include "physics/collision/core_geometry.h"
#include "physics/collision/cylinder_contacts.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

OnCore nearest_on_cylinder(Vec3 half, Vec3 point) {
    const double away = std::hypot(point.x, point.y), inward = away > half.x ? half.x / away : 1;
    const Vec3 on{inward * point.x, inward * point.y, std::clamp(point.z, -half.z, half.z)};
    const Vec3 way = point - on;
    if (const double distance = length(way); distance > 0) return {on, (1 / distance) * way, distance};
    if (half.z - std::abs(point.z) <= half.x - away) {
        const double up = point.z < 0 ? -1 : 1;
        return {{point.x, point.y, up * half.z}, {0, 0, up}, std::abs(point.z) - half.z};
    }
    const Vec3 out = away > 0 ? (1 / away) * Vec3{point.x, point.y, 0} : Vec3{1, 0, 0};
    return {{half.x * out.x, half.x * out.y, point.z}, out, away - half.x};
}

void collide_ball_and_core(const Core& ball, const Core& core, const Pose& pose, Vec3 from_core, bool ball_first, double reach,
                           Manifold& found) {
    const Vec3 ball_at = into(pose, from_core);
    const OnCore near = kind_of(core) == CoreKind::Cylinder ? nearest_on_cylinder(core.half_m, ball_at) : nearest_on(core.half_m, ball_at);
    const Vec3 out = out_of(pose, near.out);
    const double gap = near.distance - core.radius_m - ball.radius_m;
    found.normal = ball_first ? -out : out;
    // From the centre of the core; the ball is at from_core.
    const Vec3 at = out_of(pose, near.on) + (core.radius_m + 0.5 * gap) * out;
    add(found, ball_first ? at - from_core : at, gap, reach);
    found.apart_m = gap;
}

void collide_lines(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, Vec3 shift, double reach, Manifold& found) {
    if (collide_side_by_side(a, a_pose, b, b_pose, shift, reach, found)) return;
    const Vec3 u = a_pose.axes[2], v = b_pose.axes[2], across = cross(u, v);
    const double size = length(across);
    Vec3 otherwise = size > 1e-6 ? (1 / size) * across : any_across(u);
    if (dot(otherwise, shift) < 0) otherwise = -otherwise;
    add_nearest(a, b, nearest_of_lines({}, u, a.half_m.z, shift, v, b.half_m.z), otherwise, reach, found);
}

// The face of a core that looks most along a direction, or the whole of a line; its corners from the core's centre.
CornerRing<Vec3> face_along(const Core& core, const Pose& pose, Vec3 direction) {
    CornerRing<Vec3> ring;
    const Vec3 z = core.half_m.z * pose.axes[2];
    if (kind_of(core) == CoreKind::Line) {
        ring.push(z), ring.push(-z);
        return ring;
    }
    int axis = 0;
    double best = -1;
    for (int i = 0; i < 3; ++i)
        if (const double along = std::abs(dot(direction, pose.axes[static_cast<std::size_t>(i)])); along > best) axis = i, best = along;
    const auto edge = [&](int i) { return part(core.half_m, i) * pose.axes[static_cast<std::size_t>(i)]; };
    const Vec3 out = dot(direction, edge(axis)) < 0 ? -edge(axis) : edge(axis), p = edge((axis + 1) % 3), q = edge((axis + 2) % 3);
    ring.push(out + p + q), ring.push(out - p + q), ring.push(out - p - q), ring.push(out + p - q);
    return ring;
}

}  // namespace

OnCore nearest_on(Vec3 half, Vec3 point) {
    const Vec3 on{std::clamp(point.x, -half.x, half.x), std::clamp(point.y, -half.y, half.y), std::clamp(point.z, -half.z, half.z)};
    const Vec3 way = point - on;
    if (const double distance = length(way); distance > 0) return {on, (1 / distance) * way, distance};
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (part(half, i) - std::abs(part(point, i)) < part(half, axis) - std::abs(part(point, axis))) axis = i;
    OnCore found{point, {}, std::abs(part(point, axis)) - part(half, axis)};
    part(found.out, axis) = part(point, axis) < 0 ? -1 : 1;
    part(found.on, axis) = part(found.out, axis) * part(half, axis);
    return found;
}

// C. Ericson: "Real-Time Collision Detection", section 5.1.9.
LineEnds nearest_of_lines(Vec3 a_middle, Vec3 a_along, double a, Vec3 b_middle, Vec3 b_along, double b) {
    const Vec3 between = a_middle - b_middle;
    const double mixed = dot(a_along, b_along), on_a = dot(a_along, between), on_b = dot(b_along, between), area = 1 - mixed * mixed;
    double s = area > 1e-12 ? std::clamp((mixed * on_b - on_a) / area, -a, a) : 0;
    double t = mixed * s + on_b;
    if (std::abs(t) > b) {
        t = std::clamp(t, -b, b);
        s = std::clamp(mixed * t - on_a, -a, a);
    }
    return {a_middle + s * a_along, b_middle + t * b_along};
}

bool collide_side_by_side(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, Vec3 shift, double reach, Manifold& found) {
    constexpr double kParallel = 0.9985, kShort = 0.1;
    const Vec3 u = a_pose.axes[2], v = b_pose.axes[2];
    const double mixed = dot(u, v), middle = dot(shift, u), half = b.half_m.z * std::abs(mixed);
    const double low = std::max(-a.half_m.z, middle - half), high = std::min(a.half_m.z, middle + half);
    const double radii = a.radius_m + b.radius_m;
    if (std::abs(mixed) < kParallel || high - low < kShort * radii) return false;
    const auto ends = [&](double s) {
        const double t = std::clamp((s - middle) / mixed, -b.half_m.z, b.half_m.z);
        return LineEnds{s * u, shift + t * v};
    };
    const LineEnds first = ends(low), last = ends(high);
    const Vec3 across = (first.q - first.p) + (last.q - last.p), sideways = across - dot(across, u) * u;
    const double wide = length(sideways);
    found.normal = wide > kApart * radii ? (1 / wide) * sideways : any_across(u);
    for (const LineEnds& both : {first, last}) {
        const double gap = dot(both.q - both.p, found.normal) - radii;
        add(found, both.p + (a.radius_m + 0.5 * gap) * found.normal, gap, reach);
    }
    return true;
}

void add_nearest(const Core& a, const Core& b, const LineEnds& ends, Vec3 otherwise, double reach, Manifold& found) {
    const Vec3 way = ends.q - ends.p;
    const double distance = length(way), radii = a.radius_m + b.radius_m;
    found.normal = distance > 0 ? (1 / distance) * way : otherwise;
    add(found, ends.p + (a.radius_m + 0.5 * (distance - radii)) * found.normal, distance - radii, reach);
}

Pose pose_of(Vec3 centre, Quat turn) { return {centre, {rotate(turn, {1, 0, 0}), rotate(turn, {0, 1, 0}), rotate(turn, {0, 0, 1})}}; }

void collide(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, double reach_m, AxisHint& hint, Manifold& found) {
    found.count = 0, found.on_rim = false, found.apart_m = 0;
    const CoreKind first = kind_of(a), second = kind_of(b);
    const Vec3 shift = b_pose.centre - a_pose.centre;
    if (first == CoreKind::Box && second == CoreKind::Box) return collide_boxes(a, a_pose, b, b_pose, reach_m, hint, found);
    if (first >= CoreKind::Cylinder || second >= CoreKind::Cylinder) {
        if (second == CoreKind::Point) return collide_ball_and_core(b, a, a_pose, shift, false, reach_m, found);
        if (first == CoreKind::Point) return collide_ball_and_core(a, b, b_pose, -shift, true, reach_m, found);
        if (first == CoreKind::Cylinder || second == CoreKind::Cylinder)
            return collide_cylinder(a, a_pose, b, b_pose, reach_m, hint, found);
        return collide_boxes(a, a_pose, b, b_pose, reach_m, hint, found);
    }
    if (first == CoreKind::Line && second == CoreKind::Line) return collide_lines(a, a_pose, b, b_pose, shift, reach_m, found);
    if (first == CoreKind::Line) return collide_ball_and_core(b, a, a_pose, shift, false, reach_m, found);
    collide_ball_and_core(a, b, b_pose, -shift, true, reach_m, found);
}

void collide_with_plane(const Core& a, const Pose& a_pose, Vec3 normal, double offset_m, double reach_m, AxisHint& hint, Manifold& found) {
    found.count = 0, found.on_rim = false, found.apart_m = 0;
    found.normal = -normal;
    if (kind_of(a) == CoreKind::Cylinder) return collide_cylinder_with_plane(a, a_pose, normal, offset_m, reach_m, hint, found);
    const double height = dot(normal, a_pose.centre) - offset_m - a.radius_m;
    CornerRing<Vec3> ring;
    if (kind_of(a) == CoreKind::Point)
        ring.push({});
    else
        ring = face_along(a, a_pose, -normal);
    for (const Vec3 corner : ring.all()) {
        const double gap = height + dot(normal, corner);
        add(found, corner - (a.radius_m + 0.5 * gap) * normal, gap, reach_m);
    }
}

Pose pose_of_part(const ShapePart& part, const Pose& body) {
    Pose pose{centre_of(part, body), body.axes};
    if (part.turn == Quat{}) return pose;
    const auto seen = [&](Vec3 axis) {
        const Vec3 own = rotate(part.turn, axis);
        return own.x * body.axes[0] + (own.y * body.axes[1] + own.z * body.axes[2]);
    };
    pose.axes = {seen({1, 0, 0}), seen({0, 1, 0}), seen({0, 0, 1})};
    return pose;
}

PlacedSolid solid_of(const BodyShape& shape, const Pose& body, std::size_t part) {
    if (!shape.is_compound()) return {{shape.core_m, shape.rounding_m}, body};
    const ShapePart& solid = shape.parts[part];
    return {{solid.core_m, solid.rounding_m}, pose_of_part(solid, body)};
}

bool nearer(const BodyShape& a, const Attitude& a_place, const BodyShape& b, const Attitude& b_place, double within_m) {
    const Pose a_pose = pose_of(a_place.centre, a_place.turn), b_pose = pose_of(b_place.centre, b_place.turn);
    for (std::size_t i = 0; i < a.solids(); ++i)
        for (std::size_t j = 0; j < b.solids(); ++j) {
            const PlacedSolid one = solid_of(a, a_pose, i), other = solid_of(b, b_pose, j);
            Manifold found;
            AxisHint hint = kNoAxis;
            collide(one.core, one.pose, other.core, other.pose, within_m, hint, found);
            if (found.count > 0) return true;
        }
    return false;
}

}  // namespace meld::physics
