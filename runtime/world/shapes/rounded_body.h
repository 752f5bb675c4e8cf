// What a catom looks like that is no sphere: a box, a cylinder or a line, and all that is within a radius of it, turned; or which compound
// of the world it is. Lengths in catom diameters.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "runtime/world/shapes/shape.h"

namespace meld::world {

struct RoundedBody {
    // Half of the edges of the box along the body's axes; those of a line or a point are 0. (x, 0, z) is a cylinder along z of radius x and
    // half height z. Of a compound, x is the radius of the ball around it.
    Vec3 core{};
    // Of a compound, minus its number, from 1.
    double rounding = 0.5;
    // The rotation from the body's frame to the world's: w, x, y, z.
    std::array<double, 4> turn{1, 0, 0, 0};
    bool operator==(const RoundedBody&) const = default;

    static RoundedBody of_compound(std::size_t place, double radius, const std::array<double, 4>& turn) {
        return {{radius, 0, 0}, -1 - static_cast<double>(place), turn};
    }
    // Its place among the compounds of the world.
    std::optional<std::size_t> compound() const {
        return rounding < 0 ? std::optional(static_cast<std::size_t>(-rounding) - 1) : std::nullopt;
    }
};

}  // namespace meld::world
