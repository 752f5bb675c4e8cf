// Spheres against one triangle, which counts from both sides.
#pragma once

#include <optional>

#include "physics/bodies/types.h"
#include "physics/collision/ray.h"

namespace meld::physics {

struct Triangle {
    Vec3 a, b, c;
};

// The direction from which a, b, c are counter-clockwise; nothing if the triangle is a line or a point, up to rounding.
std::optional<Vec3> normal_of(const Triangle& triangle);
// The point of the triangle nearest to `p`.
Vec3 nearest_point(const Triangle& triangle, Vec3 p);
// The same for a triangle that is neither a line nor a point: in a third of the time.
Vec3 nearest_in_face(const Triangle& triangle, Vec3 p);
// Where a ray passes through the triangle, as a share of its way; nothing if it lies in its plane.
std::optional<double> share_at(const Triangle& triangle, const Ray& ray);
// Where a sphere that moves along `path` first touches the triangle: the share of the path, 0 to 1, and the point. Nothing if it passes by
// or touches already.
struct Impact {
    double share;
    Vec3 point;
};
std::optional<Impact> impact_on(const Triangle& triangle, Vec3 centre, double radius_m, Vec3 path);

}  // namespace meld::physics
