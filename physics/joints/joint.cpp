#include "physics/joints/joint.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/bodies/symmetric.h"

namespace meld::physics {

namespace {

constexpr Vec3 kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

// At right angles to a unit vector: across the axis of the world that is farthest from it.
Vec3 any_across(Vec3 axis) {
    const Vec3 size{std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)};
    const Vec3 far = size.x <= size.y && size.x <= size.z ? kAxes[0] : size.y <= size.z ? kAxes[1] : kAxes[2];
    const Vec3 across = cross(axis, far);
    return (1 / length(across)) * across;
}

// Where the two halves of the anchor are.
struct Anchors {
    Vec3 first_arm, second_arm, apart;
};
Anchors anchors_of(const Joint& joint, const JointPose& first, const JointPose& second) {
    const Vec3 one = rotate(first.turn, joint.first_anchor), other = rotate(second.turn, joint.second_anchor);
    return {one, other, (second.centre_m - first.centre_m) + (other - one)};
}

// The small rotation that the second body of a slider has made against the first one.
Vec3 turned_away(const Joint& joint, const JointPose& first, const JointPose& second) {
    const Quat off = product(second.turn, conjugate(product(first.turn, joint.reference)));
    const double scale = off.w < 0 ? -2 : 2;
    return {scale * off.x, scale * off.y, scale * off.z};
}

}  // namespace

Joint make_joint(const JointSpec& spec, const JointPose& first, const JointPose& second) {
    Joint joint;
    joint.kind = spec.kind;
    joint.first = spec.first, joint.second = spec.second;
    const Quat to_first = conjugate(first.turn), to_second = conjugate(second.turn);
    joint.first_anchor = rotate(to_first, spec.anchor_m - first.centre_m);
    joint.second_anchor = rotate(to_second, spec.anchor_m - second.centre_m);
    joint.reference = product(to_first, second.turn);
    if (joint.moves_along()) {
        const Vec3 axis = (1 / length(spec.axis)) * spec.axis;
        joint.first_axis = rotate(to_first, axis), joint.second_axis = rotate(to_second, axis);
        joint.across = rotate(to_first, any_across(axis));
    }
    joint.lower = spec.lower, joint.upper = spec.upper, joint.strength = spec.strength;
    joint.servo_speed = spec.servo_speed, joint.response_s = spec.response_s;
    joint.stiffness = spec.stiffness, joint.damping = spec.damping, joint.rest = spec.rest;
    joint.drive = spec.drive.kind, joint.target = spec.drive.target;
    joint.breaking_force = spec.breaking_force_n, joint.breaking_torque = spec.breaking_torque_nm;
    return joint;
}

Joint carried_joint(const Joint& joint, const Carried& first, const Carried& second) {
    Joint seen = joint;
    seen.first_anchor = first.offset_m + rotate(first.turn, joint.first_anchor);
    seen.second_anchor = second.offset_m + rotate(second.turn, joint.second_anchor);
    seen.first_axis = rotate(first.turn, joint.first_axis), seen.second_axis = rotate(second.turn, joint.second_axis);
    seen.across = rotate(first.turn, joint.across);
    seen.reference = product(product(first.turn, joint.reference), conjugate(second.turn));
    return seen;
}

double Joint::give() const {
    constexpr double kShare = 1e-3;
    return kind == JointKind::Slider ? kShare * std::max(length(first_anchor) + length(second_anchor), 1e-6) : kShare;
}

double Joint::end_step(Vec3 apart_m, double dt_s) {
    const double distance = length(apart_m);
    const Vec3 line = distance > 0 ? (1 / distance) * apart_m : Vec3{};
    const double pulled = -dot(pushed, line);
    const JointLoad carried{pulled / dt_s, length(pushed + pulled * line) / dt_s, length(twisted) / dt_s};
    pushed = twisted = {};
    sum = {sum.tension_n + dt_s * carried.tension_n, sum.shear_n + dt_s * carried.shear_n, sum.torque_nm + dt_s * carried.torque_nm};
    sum_s += dt_s;
    constexpr double kEndless = std::numeric_limits<double>::infinity();
    const double force = breaking_force == kEndless ? 0 : carried.force_n() / breaking_force;
    return std::max(force, carried.torque_nm / breaking_torque);
}

double place_of(const Joint& joint, const JointPose& first, const JointPose& second) {
    if (joint.kind == JointKind::Ball) return 0;
    if (joint.kind == JointKind::Slider) return dot(rotate(first.turn, joint.first_axis), anchors_of(joint, first, second).apart);
    constexpr double kTurn = 2 * std::numbers::pi;
    const Quat turned = product(product(conjugate(first.turn), second.turn), conjugate(joint.reference));
    const double angle = 2 * std::atan2(dot({turned.x, turned.y, turned.z}, joint.first_axis), turned.w);
    return angle + kTurn * std::round((joint.place - angle) / kTurn);
}

JointRows rows_of(const Joint& joint, const JointPose& first, const JointPose& second) {
    JointRows rows;
    const Anchors at = anchors_of(joint, first, second);
    const Vec3 axis = rotate(first.turn, joint.first_axis), across = rotate(first.turn, joint.across), along = cross(axis, across);
    const auto turns = [](Vec3 about) { return JointRow{{}, -about, about}; };
    if (joint.kind == JointKind::Slider) {
        // Its lines are fixed in the first body, and are felt where the second one is.
        const Vec3 arm = at.first_arm + at.apart;
        const auto moves = [&](Vec3 line) { return JointRow{line, -cross(arm, line), cross(at.second_arm, line)}; };
        for (std::size_t i = 0; i < 3; ++i) rows[i] = turns(kAxes[i]);
        rows[3] = moves(across), rows[4] = moves(along), rows[kDriveRow] = moves(axis);
        return rows;
    }
    for (std::size_t i = 0; i < 3; ++i) rows[i] = {kAxes[i], -cross(at.first_arm, kAxes[i]), cross(at.second_arm, kAxes[i])};
    if (joint.kind == JointKind::Hinge) rows[3] = turns(across), rows[4] = turns(along), rows[kDriveRow] = turns(axis);
    return rows;
}

std::array<double, kJointRows> errors_of(const Joint& joint, const JointPose& first, const JointPose& second) {
    std::array<double, kJointRows> errors{};
    const Vec3 apart = anchors_of(joint, first, second).apart;
    const Vec3 axis = rotate(first.turn, joint.first_axis), across = rotate(first.turn, joint.across), along = cross(axis, across);
    if (joint.kind == JointKind::Slider) {
        const Vec3 turned = turned_away(joint, first, second);
        errors[0] = turned.x, errors[1] = turned.y, errors[2] = turned.z;
        errors[3] = dot(across, apart), errors[4] = dot(along, apart);
        return errors;
    }
    errors[0] = apart.x, errors[1] = apart.y, errors[2] = apart.z;
    if (joint.kind == JointKind::Hinge) {
        const Vec3 tilt = cross(axis, rotate(second.turn, joint.second_axis));
        errors[3] = dot(across, tilt), errors[4] = dot(along, tilt);
    }
    return errors;
}

}  // namespace meld::physics
