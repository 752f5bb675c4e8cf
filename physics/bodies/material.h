// The surface properties of bodies and obstacles.
#pragma once

#include <algorithm>
#include <cmath>

namespace meld::physics {

struct Material {
    // Coulomb friction; a contact has the geometric mean of both.
    float friction = 0.5f;
    // The share of the approach speed with which surfaces part; a contact has the larger of both.
    float restitution = 0.0f;
    // The radii of the patch on which surfaces press on each other, for friction against rolling and against spinning about the normal;
    // a contact has the larger of both.
    float rolling_m = 0.0f, spinning_m = 0.0f;

    bool resists_turning() const { return rolling_m > 0 || spinning_m > 0; }
};

inline float common_friction(const Material& one, const Material& other) { return std::sqrt(one.friction * other.friction); }
inline float common_rolling_m(const Material& one, const Material& other) { return std::max(one.rolling_m, other.rolling_m); }
inline float common_spinning_m(const Material& one, const Material& other) { return std::max(one.spinning_m, other.spinning_m); }

}  // namespace meld::physics
