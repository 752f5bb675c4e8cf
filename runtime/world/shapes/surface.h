// The triangles of shapes that have some.
#pragma once

#include <optional>

#include "runtime/world/model/triangles.h"
#include "runtime/world/shapes/shape.h"

namespace meld::world {

// The surface of a model, also one that is moved, rotated and scaled, in diameters; nothing for other shapes. The triangles are
// counter-clockwise as seen from outside, as far as a closed surface of one piece goes.
std::optional<model::Triangles> surface(const Shape& shape);

}  // namespace meld::world
