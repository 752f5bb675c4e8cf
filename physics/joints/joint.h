// A joint between two bodies: what it lets them do, what drives it, and its state.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "physics/bodies/types.h"

namespace meld::physics {

// Hinge: the bodies turn about a common axis. Slider: they move along an axis and do not turn against each other. Ball: they turn about a
// common point.
enum class JointKind : std::uint8_t { Hinge, Slider, Ball };

// What acts along the direction in which a hinge turns or a slider moves: nothing; what brings it to a speed, or to a place; what stops it.
struct JointDrive {
    enum class Kind : std::uint8_t { Coast, Motor, Servo, Brake };
    Kind kind = Kind::Coast;
    // Motor: rad/s or m/s; servo: rad or m. Of the second body as the first one sees it.
    double target = 0;
};

struct JointSpec {
    JointKind kind = JointKind::Hinge;
    BodyId first = 0, second = 0;
    // In the world, as the bodies are now. The axis has any length but 0, and a ball has none.
    Vec3 anchor_m = {};
    Vec3 axis = {0, 0, 1};
    // Of the angle in rad or the way in m, which are 0 now.
    double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
    // The greatest torque or force of motor, servo and brake, N m or N.
    double strength = 0;
    // The greatest speed of a servo, and the time in which it would arrive if nothing held it up.
    double servo_speed = std::numeric_limits<double>::infinity(), response_s = 0.02;
    // A spring and a damper: N m/rad and N m s/rad, or N/m and N s/m; `rest` is where the spring pulls to.
    double stiffness = 0, damping = 0, rest = 0;
    // It breaks if it carries more than this in a step, N or N m.
    double breaking_force_n = std::numeric_limits<double>::infinity(), breaking_torque_nm = std::numeric_limits<double>::infinity();
    JointDrive drive = {};
};

// What a joint does now: rad and rad/s, or m and m/s, of the second body as the first one sees it.
struct JointState {
    double place = 0, speed = 0;
};

// What a joint carries: the force along the line between the centres, positive if it pulls the two towards each other, and across that
// line; and the torque about the anchor that the second body carries. What motors, springs and limits do is part of it.
struct JointLoad {
    double tension_n = 0, shear_n = 0, torque_nm = 0;
    double force_n() const { return std::hypot(tension_n, shear_n); }
};

// A hinge or a slider has five rows that hold and one along which it moves; a ball has three that hold.
inline constexpr std::size_t kJointRows = 6, kDriveRow = 5;

// Where on its curve of impulse over speed the row along which a joint moves is. Low and High: at a limit. Drive: its drive or spring does
// what the speed asks for; Plus and Minus: its drive does all it can.
enum class JointStand : std::uint8_t { Free, Low, High, Drive, Plus, Minus };

// A joint as it is kept, in the frames of its bodies.
struct Joint {
    BodyId first = 0, second = 0;
    Vec3 first_anchor = {}, second_anchor = {};
    Vec3 first_axis = {}, second_axis = {};
    // At right angles to the axis.
    Vec3 across = {};
    // The second body as the first one saw it at the start.
    Quat reference = {};
    double lower = 0, upper = 0, strength = 0, servo_speed = 0, response_s = 0, stiffness = 0, damping = 0, rest = 0, target = 0;
    double breaking_force = 0, breaking_torque = 0;
    // The angle counts whole turns.
    double place = 0;
    // Of the last substep, from which the next one starts.
    std::array<double, kJointRows> impulses = {};
    // The impulse on the second body in the present step, and the angular impulse about its anchor.
    Vec3 pushed = {}, twisted = {};
    // The load of the last steps, times their time, until somebody takes it; and the one that was taken last.
    JointLoad sum = {}, load = {};
    double sum_s = 0;
    JointKind kind = JointKind::Hinge;
    JointDrive::Kind drive = JointDrive::Kind::Coast;
    JointStand stand = JointStand::Free;
    std::uint8_t zero[5] = {};

    bool moves_along() const { return kind != JointKind::Ball; }
    bool is_spring() const { return stiffness > 0 || damping > 0; }
    // By how much a servo or a brake gives way to a load that needs all its strength, rad or m.
    double give() const;
    // Ends a step of this length after which its second body is there as the first one sees it: counts what it has carried in, and returns
    // by which factor that is more than it carries; up to 1 it holds.
    double end_step(Vec3 apart_m, double dt_s);
};

// A body as joints see it.
struct JointPose {
    Vec3 centre_m = {};
    Quat turn = {};
};

// The joint of bodies that are here now.
Joint make_joint(const JointSpec& spec, const JointPose& first, const JointPose& second);
// The same joint in the frames of what carries its bodies: where each body is there.
struct Carried {
    Vec3 offset_m = {};
    Quat turn = {};
};
Joint carried_joint(const Joint& joint, const Carried& first, const Carried& second);
// Its angle or way; the angle is the one nearest to its place.
double place_of(const Joint& joint, const JointPose& first, const JointPose& second);

// A row J of a joint: its speed is linear * (v2 - v1) + first * w1 + second * w2.
struct JointRow {
    Vec3 linear = {}, first = {}, second = {};

    double speed(Vec3 first_velocity, Vec3 first_spin, Vec3 second_velocity, Vec3 second_spin) const {
        return dot(linear, second_velocity - first_velocity) + (dot(first, first_spin) + dot(second, second_spin));
    }
};
using JointRows = std::array<JointRow, kJointRows>;
// Rows that a joint has not are zero.
JointRows rows_of(const Joint& joint, const JointPose& first, const JointPose& second);
// How far each row that holds is from where it should be, m or rad; the row along which it moves is 0.
std::array<double, kJointRows> errors_of(const Joint& joint, const JointPose& first, const JointPose& second);

}  // namespace meld::physics
