// Joints between the bodies of a scene.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/scene/scene.h"
#include "physics/solver/engine.h"

namespace meld::physics {

namespace {

// What is wrong with the numbers of a joint; nothing: they are fine.
Result<void> check(const JointSpec& joint) {
    const auto wrong = [&](std::string_view what, const char* cure) {
        return fail(fmt::format("the joint of bodies {} and {} {}", joint.first, joint.second, what), cure);
    };
    if (!is_finite(joint.anchor_m)) return wrong("has an anchor that is not finite", "Give it a place");
    if (!(joint.breaking_force_n > 0) || !(joint.breaking_torque_nm > 0))
        return wrong("breaks at a load that is not positive", "Give a positive limit, or infinity");
    if (joint.kind == JointKind::Ball) return {};
    if (const double size = length(joint.axis); !(size > 0) || !std::isfinite(size)) return wrong("has no axis", "Give it a direction");
    if (!(joint.lower <= 0 && joint.upper >= 0)) return wrong("is beyond its limits at the start", "Give it limits around 0");
    for (const double value : {joint.strength, joint.stiffness, joint.damping})
        if (!(value >= 0) || !std::isfinite(value))
            return wrong("has a strength, stiffness or damping that is negative or not finite", "Give it numbers from 0 on");
    for (const double value : {joint.rest, joint.drive.target})
        if (!std::isfinite(value)) return wrong("has a target that is not finite", "Give it a number");
    if (!(joint.servo_speed > 0) || !(joint.response_s > 0))
        return wrong("has a servo that never moves", "Give it a positive speed and time");
    if ((joint.stiffness > 0 || joint.damping > 0) && joint.strength > 0) return wrong("has a spring and a motor", "Leave one of them out");
    return {};
}

// ODE counts angles up to half a turn, and a spring against a limit would push without bounds.
Result<void> check_for_ode(const JointSpec& joint) {
    const auto cannot = [&](std::string_view why, const char* cure) {
        return fail(fmt::format("the joint of bodies {} and {} {}, which the engine Ode does not hold", joint.first, joint.second, why),
                    cure);
    };
    const bool limited = std::isfinite(joint.lower) || std::isfinite(joint.upper);
    constexpr double kHalfTurn = std::numbers::pi;
    if (joint.kind == JointKind::Hinge && limited && !(joint.lower > -kHalfTurn && joint.upper < kHalfTurn))
        return cannot("has a limit, but not two within half a turn", "Use the engine Blocks, or give it both");
    if (limited && (joint.stiffness > 0 || joint.damping > 0))
        return cannot("has a spring and limits", "Use the engine Blocks, or leave one of them out");
    return {};
}

}  // namespace

Result<void> Scene::add_joint(const JointSpec& joint) {
    for (const BodyId one : {joint.first, joint.second})
        if (auto fine = known(one); !fine) return fine;
    return add_joint(joint, pose(joint.first), pose(joint.second));
}

Result<void> Scene::add_joint(const JointSpec& joint, const JointPose& first, const JointPose& second) {
    const auto cannot = [&](std::string_view why, const char* cure) {
        return fail(fmt::format("bodies {} and {} cannot be joined ({})", joint.first, joint.second, why), cure);
    };
    if (joint.first == joint.second) return cannot("they are one", "Name another body");
    const EngineKind engine = world_->settings.engine;
    if (engine == EngineKind::Hash) return cannot("the engine Hash has no joints", "Use the engine Blocks or Ode");
    if (engine == EngineKind::Ode)
        if (auto fine = check_for_ode(joint); !fine) return fine;
    if (engine_->divided() && !has_all_joined_) return cannot("the world is divided", "Join them before");
    if (joined(joint.first, joint.second)) return cannot("they are joined already", "Give two bodies one joint");
    if (auto fine = check(joint); !fine) return fine;
    const Bodies& bodies = world_->bodies;
    const auto stands = [&](BodyId one) { return has(one) && (bodies.properties[bodies.slot(one)].flags & kFixed) != 0; };
    if (stands(joint.first) && stands(joint.second)) return cannot("both are fixed", "Join bodies of which one can move");
    world_->joints.add(make_joint(joint, first, second));
    world_->composites.joined().add(joint.first, joint.second);
    joints_changed(joint.first, joint.second);
    return {};
}

Result<void> Scene::remove_joint(BodyId body, BodyId other) {
    if (!joined(body, other)) return fail(fmt::format("bodies {} and {} have no joint", body, other), "Name bodies that are joined");
    if (engine_->divided() && !has_all_joined_)
        return fail(fmt::format("the joint of bodies {} and {} cannot be removed (the world is divided)", body, other),
                    "Let all subdomains have all joints");
    world_->joints.remove(body, other);
    world_->composites.joined().remove(body, other);
    joints_changed(body, other);
    return {};
}

// Both begin or end to collide, and may move.
void Scene::joints_changed(BodyId body, BodyId other) {
    engine_->structure_changed();
    for (const BodyId one : {body, other})
        if (has(one)) engine_->body_changed(world_->bodies.slot(one), false);
}

JointPose Scene::pose(BodyId body) const { return joint_pose(world_->bodies, world_->bodies.slot(body)); }

BodyId Scene::mover_of(BodyId body) const { return world_->movers().of(body); }

Result<void> Scene::drive_joint(BodyId body, BodyId other, const JointDrive& drive) {
    for (const BodyId one : {body, other})
        if (auto fine = known(one); !fine) return fine;
    const Joint* joint = world_->joints.find(body, other);
    if (joint == nullptr) return fail(fmt::format("bodies {} and {} have no joint", body, other), "Name bodies that are joined");
    if (!joint->moves_along()) return fail(fmt::format("the joint of bodies {} and {} is a ball", body, other), "Drive hinges and sliders");
    if (!std::isfinite(drive.target))
        return fail(fmt::format("the joint of bodies {} and {} is driven to {}", body, other, drive.target), "Give it a number");
    const bool brakes = drive.kind == JointDrive::Kind::Brake;
    if (joint->drive == drive.kind && (brakes || joint->target == drive.target)) return {};
    world_->joints.drive(body, other, {drive.kind, brakes ? this->joint(body, other)->place : drive.target});
    for (const BodyId one : {body, other}) engine_->body_changed(world_->bodies.slot(one), false);
    return {};
}

void Scene::wake_joined(BodyId body) {
    for (const BodyId other : joined_to(body)) engine_->body_changed(world_->bodies.slot(other), false);
}

bool Scene::joined(BodyId body, BodyId other) const { return world_->composites.joined().has(body, other); }

std::span<const BodyId> Scene::joined_to(BodyId body) const { return world_->composites.joined().of(body); }

std::size_t Scene::joint_count() const {
    const auto joints = world_->joints.all();
    return static_cast<std::size_t>(std::ranges::count_if(joints, [&](const Joint& joint) { return counts(joint); }));
}

bool Scene::counts(const Joint& joint) const {
    return has(joint.first) && (world_->bodies.properties[world_->bodies.slot(joint.first)].flags & kGhost) == 0;
}

std::optional<JointKind> Scene::joint_kind(BodyId body, BodyId other) const {
    const Joint* joint = world_->joints.find(body, other);
    return joint == nullptr ? std::nullopt : std::optional(joint->kind);
}

bool Scene::has_motor(BodyId body, BodyId other) const {
    const Joint* joint = world_->joints.find(body, other);
    return joint != nullptr && joint->strength > 0;
}

std::span<const Joint> Scene::joints() const { return world_->joints.all(); }

Scene::JointPlace Scene::place_of(const Joint& joint) const {
    const BodyState first = state(joint.first), second = state(joint.second);
    return {first.position_m + rotate(first.orientation, joint.first_anchor),
            second.position_m + rotate(second.orientation, joint.second_anchor), rotate(first.orientation, joint.first_axis)};
}

std::optional<JointLoad> Scene::joint_load(BodyId body, BodyId other) const {
    const Joint* joint = world_->joints.find(body, other);
    return joint == nullptr ? std::nullopt : std::optional(joint->load);
}

std::span<const ConnectionPair> Scene::broken_joints() const { return world_->joints.broken(); }

std::optional<JointState> Scene::joint(BodyId body, BodyId other) const {
    const Joint* joint = world_->joints.find(body, other);
    if (joint == nullptr) return std::nullopt;
    if (!joint->moves_along()) return JointState{};
    const Bodies& bodies = world_->bodies;
    const JointPose first = joint_pose(bodies, bodies.slot(joint->first)), second = joint_pose(bodies, bodies.slot(joint->second));
    const BodyState one = state(joint->first), two = state(joint->second);
    const JointRow row = rows_of(*joint, first, second)[kDriveRow];
    return JointState{physics::place_of(*joint, first, second),
                      row.speed(one.linear_velocity_m_s, one.angular_velocity_rad_s, two.linear_velocity_m_s, two.angular_velocity_rad_s)};
}

}  // namespace meld::physics
