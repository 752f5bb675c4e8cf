// What programs ask of their bodies: magnet, latch, force, torque, roll.
#pragma once

#include <optional>
#include <vector>

#include "runtime/sim/part_state.h"
#include "runtime/sim/physics_scene.h"

namespace meld::sim {

class BodyActions {
  public:
    // Also the codes that `failed` carries (stdlib/prelude.meld).
    enum class Code : std::int64_t { Magnet = 20, Latch = 21 };

    void start(const PartState& part, const world::World& world);
    // Switches what is to be switched, and takes in the pushes of this tick. All parts are told all, since a body may be known
    // to several and may change hands within the tick. Every part calls it.
    Result<void> take(PartState& part, PhysicsScene& physics);
    // Before each step of the tick: pushes, and the torques that bring rolling catoms to their spins. Errors: a push that is
    // not finite.
    Result<void> push(physics::Scene& scene, double step_s);
    // Whether anything is pushed in this tick; the same on all parts.
    bool any_pushes() const { return !pushed_.empty(); }
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
    void share(PartState& part);
    void refuse(PartState& part, Catom catom, Code code);

    const world::World* world_ = nullptr;
    std::optional<u32> magnet_, latch_, failed_;
    Form force_, torque_, roll_;
    std::vector<Pushed> pushed_;
    std::vector<Switched> switched_;
};

}  // namespace meld::sim
