// The actions of programs on their bodies: magnet, supply, latch, force, torque, roll; and those that connect them, make joints of them,
// drive these, or dim their lamps, which body_connections.h, joint_changes.h, body_joints.h and lamps.h carry out.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "runtime/module/abi/actions.h"
#include "runtime/sim/bodies/body_connections.h"
#include "runtime/sim/bodies/body_joints.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/bodies/joint_changes.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/bodies/senses/lamps.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class BodyActions {
  public:
    void start(const Subdomain& subdomain, const world::World& world);
    // Switches features and collects the wrenches of this tick. Notifies processes that hold a ghost of the body. Every process calls it;
    // `divided` if there are several.
    Result<void> take(Subdomain& subdomain, PhysicsScene& physics, const DividedBodies* divided);
    // The connections that this tick's actions are about, in the order of the catoms.
    std::span<const AskedConnection> asked() const { return asked_; }
    // And those about what drives joints, and which joints there are.
    std::span<const AskedDrive> asked_drives() const { return asked_drives_; }
    std::span<const AskedJoint> asked_joints() const { return asked_joints_; }
    // And those about lamps.
    std::span<const AskedLamp> asked_lamps() const { return asked_lamps_; }
    // Counts an action that was not carried out, and tells the catom if its program wants to know.
    void report_failed(Subdomain& subdomain, Catom catom, ActionKind action, Refusal why);
    // Call it after bodies have migrated within the tick: wrenches follow them. Every process calls it.
    void follow(Subdomain& subdomain, const DividedBodies& divided);
    // Before each step of the tick: sets the wrenches, and the torques that bring rolling catoms to their angular velocities. Errors: a
    // wrench that is not finite.
    Result<void> apply(physics::Scene& scene, double step_s);
    // Whether any wrench may act in this tick; the same on all processes.
    bool any_wrenches() const { return acting_; }
    // After the last step: removes the wrenches.
    Result<void> release(physics::Scene& scene);

  private:
    struct AppliedWrench {
        physics::BodyId body;
        bool rolls = false;
        physics::Vec3 force_n = {}, torque_nm = {}, angular_velocity_rad_s = {};
    };
    struct Switched {
        physics::BodyId body;
        physics::SwitchedFeatures features;
    };
    // The current of an electromagnet, A, or the voltage of a plate, V.
    struct Supplied {
        physics::BodyId body;
        std::uint32_t feature;
        double level;
    };
    // What processes with ghosts are told about.
    enum class Notice : std::uint8_t { Wrench, Switched, Supplied };
    static physics::Vec3 vector_of(const Subdomain& subdomain, const eval::Action& action);
    AppliedWrench& applied_to(physics::BodyId body);
    Result<void> set_features(physics::Scene& scene) const;
    bool switch_feature(Subdomain& subdomain, const PhysicsScene& physics, const eval::Action& action);
    void notify_holders(Subdomain& subdomain, const DividedBodies& divided, bool switches);
    template <class Act>
    Result<void> each_applied(const physics::Scene& scene, const Act& act);

    const world::World* world_ = nullptr;
    std::optional<u32> failed_;  // If the program uses it.
    bool acting_ = false;
    // Of our bodies and of ghosts.
    std::vector<AppliedWrench> applied_, received_;
    std::vector<Switched> switched_;
    std::vector<Supplied> supplied_;
    std::vector<AskedConnection> asked_;
    std::vector<AskedDrive> asked_drives_;
    std::vector<AskedJoint> asked_joints_;
    std::vector<AskedLamp> asked_lamps_;
};

}  // namespace meld::sim
