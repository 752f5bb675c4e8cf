// Where two latches or electrodes hold each other.
#pragma once

#include "physics/bodies/types.h"

namespace meld::physics {

// In the middle between them, with up to a force, N, along an axis from a to b. They are nearer to each other than the range.
struct HeldPlace {
    Vec3 at_m, axis;
    double force_n = 0, range_m = 0;
};

}  // namespace meld::physics
