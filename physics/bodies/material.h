// The surface properties of bodies and obstacles.
#pragma once

#include <cmath>

namespace meld::physics {

struct Material {
    // Coulomb friction; a contact has the geometric mean of both.
    float friction = 0.5f;
    // The share of the approach speed with which surfaces part; a contact has the larger of both.
    float restitution = 0.0f;
};

inline float common_friction(const Material& one, const Material& other) { return std::sqrt(one.friction * other.friction); }

}  // namespace meld::physics
