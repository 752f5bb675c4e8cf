// What the files about contacts of cores share: their kinds, frames and nearest points of lines.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "physics/collision/core_contacts.h"

namespace meld::physics {

inline constexpr double kNever = std::numeric_limits<double>::infinity();
// Shares of the least thickness: cores nearer than this count as touching; and a point over a face may be this much farther away than the
// face's plane.
inline constexpr double kApart = 1e-7, kOverFace = 1e-3;
// Faces that differ by less than this angle, as its cosine and sine, lie on each other: they touch in several points, whose normal is that
// of one of them, although one point between their edges may be a little nearer.
inline constexpr double kFlat = 0.98, kSlant = 0.2;

// A triangle is no core of a shape; see PlacedCore.
enum class CoreKind { Point, Line, Cylinder, Box, Triangle };
inline CoreKind kind_of(const Core& core) {
    if (core.half_m.y > 0) return CoreKind::Box;
    return core.half_m.x > 0 ? CoreKind::Cylinder : core.half_m.z > 0 ? CoreKind::Line : CoreKind::Point;
}

inline double& part(Vec3& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; }
inline double part(const Vec3& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; }
inline Vec3 into(const Pose& pose, Vec3 v) { return {dot(v, pose.axes[0]), dot(v, pose.axes[1]), dot(v, pose.axes[2])}; }
inline Vec3 out_of(const Pose& pose, Vec3 v) { return v.x * pose.axes[0] + (v.y * pose.axes[1] + v.z * pose.axes[2]); }

inline Vec3 any_across(Vec3 v) {
    const Vec3 other = std::abs(v.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 found = cross(v, other);
    return (1 / length(found)) * found;
}

inline void add(Manifold& found, Vec3 at, double gap_m, double reach_m) {
    if (gap_m > reach_m || found.count == kMaxManifoldPoints) return;
    found.points[static_cast<std::size_t>(found.count++)] = {at, gap_m};
}

// The point of a core's surface that is nearest to a point, both in the core's frame: the direction out of the core there, and how far
// along it the point is (negative: inside).
struct OnCore {
    Vec3 on, out;
    double distance;
};
// Of a box or a line.
OnCore nearest_on(Vec3 half, Vec3 point);

// The corners of a face in their order, or the ends of a line. A face that another one of four corners has cut has at most eight.
template <class T>
struct CornerRing {
    std::array<T, 8> corners;
    int count = 0;
    void push(const T& corner) {
        if (count < 8) corners[static_cast<std::size_t>(count++)] = corner;
    }
    std::span<const T> all() const { return std::span(corners).first(static_cast<std::size_t>(count)); }
};

// A point on each of two cores, from the centre of the first body.
struct LineEnds {
    Vec3 p, q;
};
// The nearest points of two lines from their middles, of half lengths a and b along unit vectors.
LineEnds nearest_of_lines(Vec3 a_middle, Vec3 a_along, double a, Vec3 b_middle, Vec3 b_along, double b);

// Lines that are nearly parallel and side by side meet at both ends of their common stretch. False: they are not.
bool collide_side_by_side(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, Vec3 shift, double reach, Manifold& found);

// The manifold of one point, between the nearest points of the cores; `otherwise` is its normal where these are the same.
void add_nearest(const Core& a, const Core& b, const LineEnds& ends, Vec3 otherwise, double reach, Manifold& found);

}  // namespace meld::physics
