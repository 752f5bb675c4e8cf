#include "runtime/sim/bodies/joint_spec.h"

#include <numbers>
#include <string_view>

#include "runtime/sim/bodies/physics_scene.h"

namespace meld::sim {

namespace {

physics::JointKind kind_of(const world::JointOptions& joint) {
    return joint.kind == "ball"     ? physics::JointKind::Ball
           : joint.kind == "slider" ? physics::JointKind::Slider
                                    : physics::JointKind::Hinge;
}

}  // namespace

physics::JointDrive::Kind drive_of(std::string_view word) {
    using Kind = physics::JointDrive::Kind;
    return word == "motor" ? Kind::Motor : word == "servo" ? Kind::Servo : word == "brake" ? Kind::Brake : Kind::Coast;
}

physics::JointSpec joint_spec(const world::World& world, const world::JointOptions& joint, const JointEnd& first, const JointEnd& second) {
    physics::JointSpec spec{.kind = kind_of(joint), .first = first.id, .second = second.id};
    const physics::Vec3 one = first.pose.centre_m, other = second.pose.centre_m;
    const double share = first.radius_m / (first.radius_m + second.radius_m);
    spec.anchor_m = joint.anchor ? to_metres(world, *joint.anchor) : one + share * (other - one);
    spec.axis = {joint.axis[0], joint.axis[1], joint.axis[2]};
    const double unit = spec.kind == physics::JointKind::Slider ? 2 * world.radius : std::numbers::pi / 180;
    if (joint.limits) spec.lower = unit * (*joint.limits)[0], spec.upper = unit * (*joint.limits)[1];
    spec.strength = joint.strength;
    spec.servo_speed = joint.speed.value_or(spec.servo_speed);
    // As long as a servo takes few steps, it neither jerks nor lags.
    constexpr double kStepsOfServo = 5;
    spec.response_s = joint.response.value_or(kStepsOfServo * world.physics.step);
    spec.stiffness = joint.stiffness, spec.damping = joint.damping, spec.rest = unit * joint.rest;
    spec.breaking_force_n = joint.breaking_force.value_or(spec.breaking_force_n);
    spec.breaking_torque_nm = joint.breaking_torque.value_or(spec.breaking_torque_nm);
    spec.drive = {drive_of(joint.drive), joint.drive == "servo" ? unit * joint.target : joint.target};
    return spec;
}

physics::JointSpec joint_spec_of_kind(const world::World& world, const world::JointOptions& kind, const JointEnd& first,
                                      const JointEnd& second) {
    physics::JointSpec spec = joint_spec(world, kind, first, second);
    if (kind.anchor) spec.anchor_m = first.pose.centre_m + rotate(first.pose.turn, to_metres(world, *kind.anchor));
    spec.axis = rotate(first.pose.turn, spec.axis);
    return spec;
}

}  // namespace meld::sim
