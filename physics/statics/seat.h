// Where a connection holds two bodies of which one has a shape: in the middle of what touches.
#pragma once

#include "physics/bodies/body_shape.h"
#include "physics/bodies/types.h"

namespace meld::physics {

// A body as it lies in its composite; a sphere is a shape without a core.
struct Seated {
    BodyShape shape;
    Vec3 place_m = {};
    Quat turn = {};
    bool operator==(const Seated&) const = default;
};

// `at`: the middle of the faces, edges or points of the two that touch or are nearest to each other. `along`: a unit vector across them,
// from one body to the other. `radius_m`: half of the thickness of the thinner one.
struct Seat {
    Vec3 at = {}, along = {1, 0, 0};
    double radius_m = 0.5;
};
// Cost: below two microseconds.
Seat seat_between(const Seated& one, const Seated& other);

}  // namespace meld::physics
