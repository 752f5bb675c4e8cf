// The surface properties of bodies and obstacles.
#pragma once

namespace meld::physics {

struct Material {
    // Coulomb friction; a contact has the geometric mean of both.
    float friction = 0.5f;
    // The share of the approach speed with which surfaces part; a contact has the larger of both.
    float restitution = 0.0f;
};

}  // namespace meld::physics
