// The obstacles of a world as the physics knows them.
#pragma once

#include <string>

#include "physics/collision/obstacles.h"
#include "runtime/base/error.h"
#include "runtime/world/description/physics_options.h"
#include "runtime/world/description/world.h"

namespace meld::world {

// `diameter_m`: of a catom of the world.
physics::Shape shape_of(const ObstacleOptions& obstacle, double diameter_m);
// What is in the way of the points of a world, in diameters. Errors name the place of what is wrong.
Result<physics::Obstacles> obstacles_of_points(const RangeOptions& links);

}  // namespace meld::world
