// Joints of bodies as what they are: a hinge is a pin along its axis, a slider a rail, a ball a ball.
#pragma once

#include <span>

#include "runtime/show/picture/stage.h"
#include "runtime/world/shapes/joint_look.h"

namespace meld::picture {

// Adds to what stands around the catoms those joints whose two catoms are shown, and an arm to each catom that ends before its anchor.
// Nothing if there are so many that the picture would be of them alone. Cost: about a hundred triangles for each.
void add_joints(std::span<const world::JointLook> joints, Stage& stage);

}  // namespace meld::picture
