// What programs ask of their bodies: magnet, latch, force, torque, roll.
#pragma once

#include <optional>
#include <vector>

#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/core/part_state.h"

namespace meld::sim {

class BodyActions {
  public:
    // Also the codes that `failed` carries (stdlib/prelude.meld).
    enum class Code : std::int64_t { Magnet = 20, Latch = 21 };

    void start(const PartState& part, const world::World& world);
    // Switches what is to be switched, and takes in the pushes of this tick. Those parts are told that have the body too. Every
    // part calls it; `divided` where there are several.
    Result<void> take(PartState& part, PhysicsScene& physics, const DividedBodies* divided);
    // After bodies have changed hands within the tick: pushes follow them. Every part calls it.
    void follow(PartState& part, const DividedBodies& divided);
    // Before each step of the tick: pushes, and the torques that bring rolling catoms to their spins. Errors: a push that is
    // not finite.
    Result<void> push(physics::Scene& scene, double step_s);
    // Whether anything may be pushed in this tick; the same on all parts.
    bool any_pushes() const { return pushing_; }
    // After the last step: what was pushed is left alone.
    Result<void> release(physics::Scene& scene);

  private:
    struct Form {
        std::optional<u32> numbers, vector;  // With three numbers, with a vec3.
        bool is(u32 predicate) const { return numbers == predicate || vector == predicate; }
    };
    struct Pushed {
        physics::BodyId body;
        bool rolls = false;
        physics::Vec3 force_n = {}, torque_nm = {}, spin_rad_s = {};
    };
    struct Switched {
        physics::BodyId body;
        physics::SwitchedFeatures features;
    };
    static physics::Vec3 vector_of(const PartState& part, const eval::Action& action);
    Pushed& pushed(physics::BodyId body);
    bool switch_feature(PartState& part, const PhysicsScene& physics, const eval::Action& action);
    void tell_holders(PartState& part, const DividedBodies& divided, bool switches);
    template <class Act>
    Result<void> each_pushed(const physics::Scene& scene, const Act& act);
    void refuse(PartState& part, Catom catom, Code code);

    const world::World* world_ = nullptr;
    std::optional<u32> magnet_, latch_, failed_;
    Form force_, torque_, roll_;
    bool pushing_ = false;
    // Of our bodies, and of ghosts.
    std::vector<Pushed> pushed_, told_;
    std::vector<Switched> switched_;
};

}  // namespace meld::sim
