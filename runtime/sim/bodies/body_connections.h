// Rigid connections between catoms: those of the world file, and the actions `connect` and `release`.
//
// Catoms that touch stay neighbours when they are connected. The physics ends the touches within a composite, since nothing can happen
// there; here they go on until the two no longer keep their places to each other.
#pragma once

#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/module/abi/actions.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/bodies/joint_changes.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/bodies/senses/body_senses.h"
#include "runtime/sim/core/refusals.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// An action `connect` or `release` of this tick.
struct AskedConnection {
    ActionKind action = ActionKind::None;
    Catom catom = 0;
    std::uint64_t other = 0;
};
struct RefusedConnection {
    ActionKind action = ActionKind::None;
    Catom catom = 0;
    Refusal why = Refusal::NotConnected;
};

class BodyConnections {
  public:
    explicit BodyConnections(const world::World& world) : world_(world) {}

    // Errors: the world or the program connects catoms, and this run cannot: it has another engine.
    Result<void> check(const Subdomain& subdomain) const;
    // In a world with joints, where catoms are connected or may be, or programs make joints: the same on all processes.
    bool are_beside_joints(const Subdomain& subdomain, const physics::Scene& scene) const;
    // At the start, on every process: connects the catoms of each group of the world that is connected, where they touch. `touches`: of all
    // processes.
    Result<void> connect_groups(Subdomain& subdomain, physics::Scene& scene, const BodyMaker& bodies,
                                std::span<const physics::TouchEvent> touches) const;
    // Tells programs of all connections: at the start, and in a run that goes on from a snapshot of another program.
    void sense_all(Subdomain& subdomain, const physics::Scene& scene, BodySenses& senses) const;

    // Carries out the actions of a tick, in any order with the same result: whether catoms are connected, and touch, is judged as the tick
    // found them, and a release goes before a wish to connect. Returns what was refused. Every process calls it, and all make and break
    // all connections.
    std::vector<RefusedConnection> carry_out(Subdomain& subdomain, PhysicsScene& physics, BodySenses& senses,
                                             std::span<const AskedConnection> asked) const;
    // Whether the world has limits, at which connections break.
    bool may_break() const;
    // Before bodies are removed, sorted by number: they let go of those that stay.
    void lose(Subdomain& subdomain, const physics::Scene& scene, BodySenses& senses, std::span<const physics::BodyId> lost);

    // After each step: the touches that begin and end for programs, sorted; valid until the next call. `events`: those of the physics, and
    // `recomposed`: what the step's report says.
    std::span<const physics::TouchEvent> follow(const physics::Scene& scene, std::span<const physics::TouchEvent> events, bool recomposed);
    // The same on several processes: every process calls it. Touches of catoms that have ended with a joint or a connection are in
    // parted(), on all processes alike, and not among those that it returns.
    std::span<const physics::TouchEvent> follow_together(Subdomain& subdomain, const physics::Scene& scene,
                                                         std::span<const physics::TouchEvent> events, bool recomposed);
    std::span<const physics::TouchEvent> parted() const { return parted_; }
    // After a step, on all processes: these joints have broken. Their catoms are neighbours until the next step finds whether they touch.
    // Sorted.
    void part(std::span<const physics::ConnectionPair> joints);
    // Before the first step of a tick, on all processes alike: programs have made joints and taken others off, of which all processes have
    // the catoms. Catoms of a new joint stay or become neighbours, and others as long as they touch.
    void change_joints(const PhysicsScene& physics, const ChangedJoints& changed);
    // After the first step: of the touches among connected and fixed catoms at the start, leaves those of which the physics has no event.
    // Every process calls it with those of its own catoms.
    void adopt(Subdomain& subdomain, const physics::Scene& scene, std::vector<physics::TouchEvent>& touches);

    // In a world with joints: pairs of bodies whose touches last.
    std::vector<physics::ConnectionPair> lasting() const;
    void save(ByteWriter& out) const;
    void load(ByteReader& in);
    // Whether there are the bodies of what was loaded; on several processes, where any of them is here.
    bool fits(const Subdomain& subdomain, const physics::Scene& scene) const;

  private:
    static bool touch(const Subdomain& subdomain, const PhysicsScene& physics, Catom catom, physics::BodyId body, physics::BodyId other);

    bool begins(const physics::Touch& touch) const;
    bool is_over(const physics::Scene& scene, const physics::Touch& touch) const;
    std::span<const physics::TouchEvent> follow_joints(Subdomain& subdomain, std::span<const physics::TouchEvent> events);
    bool by_world() const;

    const world::World& world_;
    // Touches that last although the physics has ended them, or, in a world with joints, has not begun them yet; sorted. On
    // several processes those of all.
    std::vector<physics::Touch> lasting_;
    // Joints have broken since touches were followed last, or a run has just gone on.
    bool joints_broke_ = true;
    // Of joints that programs have changed since then: those they have made, and of catoms that were no neighbours; and those they have
    // taken off catoms that do not touch. Sorted.
    std::vector<physics::Touch> made_, strangers_, apart_;
    std::vector<physics::TouchEvent> followed_, parted_;
};

}  // namespace meld::sim
