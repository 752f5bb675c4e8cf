// Joints between catoms: those of the world file, the actions `motor`, `servo`, `brake` and `coast`, and the sense `joint`.
//
// Catoms that a joint holds together are neighbours from the start, although the physics finds no touch between them.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "runtime/module/abi/actions.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/core/refusals.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// An action on a joint of this tick.
struct AskedDrive {
    ActionKind action = ActionKind::None;
    Catom catom = 0;
    std::uint64_t other = 0;
    double target = 0;
};
struct RefusedDrive {
    ActionKind action = ActionKind::None;
    Catom catom = 0;
    Refusal why = Refusal::NotJoined;
};

class BodyJoints {
  public:
    explicit BodyJoints(const world::World& world) : world_(world) {}

    // Finds what the program reads.
    void start(const Subdomain& subdomain);
    // At the start, on every process: makes all joints of the world, and of catoms of other processes that they hold ghosts. Errors name
    // the place in the world file.
    Result<void> join(Subdomain& subdomain, PhysicsScene& physics, const BodyMaker& bodies, double max_radius_m) const;
    // Those whom they hold together are neighbours.
    void add_touches(const physics::Scene& scene, std::vector<physics::TouchEvent>& touches) const;

    bool may_break() const;
    // Those that there are now, as they are drawn: of several processes, those that this one counts.
    std::vector<world::JointLook> looks(const physics::Scene& scene) const;

    // Carries out the actions of a tick, in any order with the same result: of several on one joint, a brake goes before a servo, a servo
    // before a motor, and a motor before coasting. Returns what was refused. Every process calls it; `divided` if there are several: all
    // that have the joint drive it.
    std::vector<RefusedDrive> carry_out(Subdomain& subdomain, physics::Scene& scene, std::span<const AskedDrive> asked,
                                        const DividedBodies* divided) const;
    // After the last step of a tick: how joints have moved, where that has changed by more than the world's thresholds.
    void sense(Subdomain& subdomain, const physics::Scene& scene) const;
    // Before bodies are removed: those that stay sense nothing of their joints with them any more.
    void lose(Subdomain& subdomain, const physics::Scene& scene, std::span<const physics::BodyId> lost) const;

  private:
    // What a catom has sensed of a joint.
    struct Reading {
        u64 other = 0;
        double place = 0, speed = 0;
        bool operator==(const Reading&) const = default;
    };
    static std::array<Value, 3> arguments_of(const Reading& reading);
    // By joint of the world: the touches that it joins.
    using Touches = std::vector<std::vector<physics::TouchEvent>>;
    Result<void> add_ghosts(Subdomain& subdomain, PhysicsScene& physics, const BodyMaker& bodies, const Touches& touches) const;
    std::vector<Reading> sensed(const Subdomain& subdomain, Catom catom) const;
    bool sense_catom(Subdomain& subdomain, const physics::Scene& scene, Catom catom, int worker) const;
    // Metres of a slider in diameters; angles stay.
    double unit_m(physics::JointKind kind) const { return kind == physics::JointKind::Slider ? 2 * world_.radius : 1; }

    const world::World& world_;
    std::optional<u32> joint_;
};

}  // namespace meld::sim
