// What the joints of a world file are in the scene of the physics.
#pragma once

#include <string_view>

#include "physics/joints/joint.h"
#include "runtime/world/description/world.h"

namespace meld::sim {

// "motor", "servo", "brake" or "coast".
physics::JointDrive::Kind drive_of(std::string_view word);

// One of the two bodies of a joint.
struct JointEnd {
    physics::BodyId id = 0;
    physics::JointPose pose = {};
    double radius_m = 0;
};

// A joint of [[motion.joint]]: its anchor and axis are those of the world.
physics::JointSpec joint_spec(const world::World& world, const world::JointOptions& joint, const JointEnd& first, const JointEnd& second);
// One of a [[motion.joint_kind]]: its anchor is seen from the centre of the first body, and both turn with it.
physics::JointSpec joint_spec_of_kind(const world::World& world, const world::JointOptions& kind, const JointEnd& first,
                                      const JointEnd& second);

}  // namespace meld::sim
