// What a catom looks like that is no sphere: a box, a cylinder or a line, and all that is within a radius of it, turned. Lengths in catom
// diameters.
#pragma once

#include <array>

#include "runtime/world/shapes/shape.h"

namespace meld::world {

struct RoundedBody {
    // Half of the edges of the box along the body's axes; those of a line or a point are 0. (x, 0, z) is a cylinder along z of radius x and
    // half height z.
    Vec3 core{};
    double rounding = 0.5;
    // The rotation from the body's frame to the world's: w, x, y, z.
    std::array<double, 4> turn{1, 0, 0, 0};
    bool operator==(const RoundedBody&) const = default;
};

}  // namespace meld::world
