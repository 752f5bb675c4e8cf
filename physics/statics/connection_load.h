// What a connection between two bodies carries, and what it carries at most.
#pragma once

#include <limits>
#include <utility>

#include "physics/bodies/types.h"

namespace meld::physics {

// At the place between two bodies where their surfaces meet, if they touch; with a shape, in the middle of what touches (seat.h).
struct ConnectionLoad {
    // Along the line between the centres, with a shape along the normal there, negative if the two are pressed together; and across it.
    double tension_n = 0, shear_n = 0;
    // About axes across that line, and about it.
    double bending_nm = 0, twist_nm = 0;

    double torque_nm() const;
    // What pulls the two apart or past each other; pressure breaks nothing.
    double tearing_n() const;
    bool operator==(const ConnectionLoad&) const = default;
};
// What a connection of a body carries at most; of the limits of its two bodies the lower ones count.
struct BreakingLimits {
    double force_n = std::numeric_limits<double>::infinity(), torque_nm = std::numeric_limits<double>::infinity();
    bool operator==(const BreakingLimits&) const = default;
};
using ConnectionPair = std::pair<BodyId, BodyId>;
struct CarriedLoad {
    ConnectionPair pair;
    ConnectionLoad load;
};

// A force, and a torque about a given point.
struct Pull {
    Vec3 force, torque;
};

}  // namespace meld::physics
