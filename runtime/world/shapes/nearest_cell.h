// The cell that stands for a catom at an arbitrary position.
#pragma once

#include "runtime/world/lattice/lattice.h"
#include "runtime/world/shapes/shape.h"

namespace meld::world {

// The cell whose centre is nearest to a position in diameters: its rounded coordinates.
Cell nearest_cell(const Vec3& position);

}  // namespace meld::world
