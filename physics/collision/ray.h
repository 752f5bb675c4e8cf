// Straight ways, and where they first meet something: a share of the way, 0 to 1, and 0 if they begin inside. Nothing if they pass by.
#pragma once

#include <optional>

#include "physics/bodies/body_shape.h"
#include "physics/bodies/types.h"

namespace meld::physics {

struct Ray {
    Vec3 from, way;
    Vec3 at(double share) const { return from + share * way; }
};

// The part of a ray that is within a box along the axes; nothing if it is outside.
struct RayPart {
    double enter = 0, leave = 1;
};
std::optional<RayPart> part_within(const Ray& ray, Vec3 low, Vec3 high);

// Where it meets a body. Cost: some nanoseconds for a sphere, some tens for others.
std::optional<double> first_on(const BodyShape& shape, Vec3 centre, Quat turn, const Ray& ray);
// From the centre of a body to its surface, along a unit vector in the body's frame.
double depth_along(const BodyShape& shape, Vec3 direction);

}  // namespace meld::physics
