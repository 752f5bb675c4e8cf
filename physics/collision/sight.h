// What is in the way: obstacles, and bodies in a grid.
#pragma once

#include <optional>

#include "physics/collision/obstacles.h"
#include "physics/collision/ray_grid.h"

namespace meld::physics {

// Where a ray first meets an obstacle. Cost: some nanoseconds for each obstacle, more for terrain and meshes that it comes near.
std::optional<double> first_on(const Obstacles& obstacles, const Ray& ray);
// Whether no obstacle is between the centres of two bodies of the grid. Rounding may make a difference between the two directions, so
// whoever must get the same names the ends in the same order.
bool is_free(const Obstacles& obstacles, const RayGrid& bodies, RayGrid::Index from, RayGrid::Index to);
// Whether there is no third body of the grid either.
bool in_sight(const Obstacles& obstacles, const RayGrid& bodies, RayGrid::Index from, RayGrid::Index to);

}  // namespace meld::physics
