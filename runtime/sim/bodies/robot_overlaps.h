// Whether robots can stand as the world places them.
#pragma once

#include "runtime/sim/bodies/physics_scene.h"

namespace meld::sim {

// Errors, with their places in the world file: parts of one robot overlap and have neither a joint nor a connection, two robots overlap, or
// two parts are to be connected and do not touch. Joints and connections have been made; on several processes, the one that has the bodies
// of all robots calls it. Cost: linear in the bodies of robots, if they are of similar size.
Result<void> check_robots(const world::World& world, const PhysicsScene& physics, const BodyMaker& bodies);

}  // namespace meld::sim
