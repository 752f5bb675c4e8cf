// The cell that stands for a catom which may be anywhere.
#pragma once

#include "runtime/world/lattice.h"
#include "runtime/world/shape.h"

namespace meld::world {

// The one whose centre is nearest to a place that is given in diameters: its rounded coordinates.
Cell nearest_cell(const Vec3& position);

}  // namespace meld::world
