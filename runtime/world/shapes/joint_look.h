// A joint between two catoms as it is drawn and recorded. Lengths in catom diameters.
#pragma once

#include <cstdint>

#include "runtime/world/shapes/shape.h"

namespace meld::world {

struct JointLook {
    enum class Kind : std::uint8_t { Hinge, Slider, Ball };
    Kind kind = Kind::Hinge;
    std::uint64_t first = 0, second = 0;
    // Where the halves of its anchor are, each seen from the middle of its catom, in the catom's own frame; in the world they are the same
    // place but for a slider. And its axis in the frame of the first catom; a ball has none.
    Vec3 first_anchor{}, second_anchor{}, axis{0, 0, 1};
    bool operator==(const JointLook&) const = default;
};

}  // namespace meld::world
