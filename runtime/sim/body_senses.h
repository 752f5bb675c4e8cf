// What catoms feel of their bodies, told to those programs that read it, and only when it has changed by enough.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "runtime/sim/divided_bodies.h"
#include "runtime/sim/exact_sum.h"
#include "runtime/sim/part_state.h"
#include "runtime/sim/physics_scene.h"

namespace meld::sim {

class BodySenses {
  public:
    // Whether the program is told of its catoms' accelerations.
    static bool feels_acceleration(const PartState& part);
    // Finds what the program reads. Errors: it reads what only a lattice has.
    Result<void> start(PartState& part, const world::World& world);
    // Touches of obstacles that began and ended; after each step.
    void note_obstacles(PartState& part, std::span<const physics::TouchEvent> events);
    // After the last step of a tick: places, and all else that is read. Cost: all catoms of the part, on all workers, and
    // for those that have changed a few comparisons.
    void sense(PartState& part, PhysicsScene& physics, const DividedBodies* divided);

  private:
    enum class Quantity { Orientation, Velocity, Acceleration, Pressure, Energy };
    struct Sensor {
        Quantity quantity;
        u32 predicate;  // That stores it.
        bool vector;    // One vec3, not numbers.
        double threshold;
    };
    struct Moved {
        Catom catom;
        bool place;     // It was told its place, or is in the target or no longer.
    };
    void find_sensor(const PartState& part, const char* name, std::size_t arity, Quantity quantity, double threshold);
    // Places of some catoms; those that are to be told something are added.
    void place(PartState& part, const physics::Scene& scene, Catom first, Catom last, std::vector<Moved>& moved);
    // Of one quantity, what was told or is now; nothing was told: no numbers.
    struct Numbers {
        std::array<double, 4> at{};
        std::size_t count = 0;
    };
    Numbers told(const PartState& part, const Sensor& sensor, Catom catom) const;
    void tell(PartState& part, const Sensor& sensor, Catom catom, const Numbers& now);
    // Tells catoms what has changed enough; all are looked at on all workers, and those told one after another.
    void tell_changes(PartState& part, const physics::Scene& scene);
    void tell_contacts(PartState& part, PhysicsScene& physics, Catom catom);
    Numbers measure(const physics::Scene& scene, Quantity quantity, physics::BodyId body) const;
    // Of this part's bodies; what presses at the rim of the part is known to the part next to it.
    void sum_normal_forces(PartState& part, physics::Scene& scene, const DividedBodies* divided);
    static bool differs(const Sensor& sensor, const Numbers& told, const Numbers& now);

    const world::World* world_ = nullptr;
    std::vector<Sensor> sensors_;
    std::vector<ExactSum> normal_force_n_;  // By slot of the scene.
    std::optional<u32> touches_obstacle_, touches_at_;  // contact(A, Obstacle), contact(A, Other, Feature).
};

}  // namespace meld::sim
