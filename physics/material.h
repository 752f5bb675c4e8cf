// What surfaces are made of.
#pragma once

namespace meld::physics {

struct Material {
    // Coulomb's; that of a contact is the geometric mean of both.
    float friction = 0.5f;
    // The share of the approach speed with which surfaces part; a contact has the larger of both.
    float restitution = 0.0f;
};

}  // namespace meld::physics
