// The obstacles of a world as the physics knows them.
#pragma once

#include <span>
#include <string>

#include "physics/collision/obstacles.h"
#include "runtime/base/error.h"
#include "runtime/world/description/physics_options.h"
#include "runtime/world/description/world.h"

namespace meld::world {

// `diameter_m`: of a catom of the world. `compounds`: of the world.
physics::Shape shape_of(const ObstacleOptions& obstacle, double diameter_m, std::span<const CompoundForm> compounds);
// Whether an obstacle is a box, a sphere, a cylinder, a capsule or a compound; and it as a solid, sharp boxes too. Lengths are in the unit
// in which a diameter of the world is `diameter`. A compound has the origin of its parts where the obstacle is, not its centre of mass.
bool is_solid(const ObstacleOptions& obstacle);
physics::Solid solid_of(const ObstacleOptions& obstacle, double diameter, std::span<const CompoundForm> compounds);
// What is in the way of the points of a world, in diameters. Errors name the place of what is wrong.
Result<physics::Obstacles> obstacles_of_points(const RangeOptions& links);

}  // namespace meld::world
