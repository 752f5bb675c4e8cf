// What a world says of how catoms and obstacles move, as the physics knows it.
#pragma once

#include "physics/bodies/prescribed_motion.h"
#include "runtime/world/description/physics_options.h"
#include "runtime/world/description/world.h"

namespace meld::world {

// The motion in the unit in which a diameter of the world is `diameter`.
physics::PrescribedMotion motion_of(const PrescribedOptions& motion, double diameter);
// Of an obstacle, about its pivot.
physics::PrescribedMotion motion_of(const ObstacleOptions& obstacle, double diameter);
// The point about which an obstacle turns, in diameters, unless it has another one: its centre; of a plane the point next to the origin; of
// terrain and of a mesh the middle of the box around its points. Cost: in proportion to these.
Vec3 pivot_of(const ObstacleOptions& obstacle);
// When a tick of a world of bodies ends, s.
double end_of_tick_s(const World& world, std::int64_t tick);

}  // namespace meld::world
