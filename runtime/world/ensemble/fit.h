// Scales a shape about the origin until it holds a given number of cells.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/lattice/lattice.h"
#include "runtime/world/shapes/shape.h"

namespace meld::world {

struct FittedShape {
    Shape shape;                   // The scaled shape, which holds at least the wanted number of cells.
    double scale = 1;              // Its size as a multiple of the given shape's.
    std::vector<CellKey> surplus;  // Cells to leave out so that exactly the wanted number is left, ascending.
};

// Finds the scale at which the number of cells reaches `wanted`. A symmetric shape gains several cells at that scale, all on its surface:
// the surplus is chosen from those, the ones farthest from the rest first and evenly among equals. The result depends only on the
// arguments. Cost: some forty counts of the shape's cells. Errors: no scale between the smallest shape and the edge of the lattice gives
// that many cells.
Result<FittedShape> fit_shape(const Shape& shape, const Lattice& lattice, std::uint64_t wanted);

}  // namespace meld::world
