// A joint between two catoms as it is drawn. Lengths in catom diameters.
#pragma once

#include <cstdint>

#include "runtime/world/shapes/shape.h"

namespace meld::world {

struct JointLook {
    enum class Kind : std::uint8_t { Hinge, Slider, Ball };
    Kind kind = Kind::Hinge;
    std::uint64_t first = 0, second = 0;
    // Where the halves of its anchor are, which are the same place but for a slider; and its axis, which a ball has not.
    Vec3 first_anchor{}, second_anchor{}, axis{0, 0, 1};
};

}  // namespace meld::world
