// What catoms sense of their bodies: written for programs that read it, when it has changed by more than a threshold.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "runtime/abi/senses.h"
#include "runtime/base/exact_sum.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/tuple/facts.h"

namespace meld::sim {

class BodySenses {
  public:
    // Whether the program senses accelerations.
    static bool senses_acceleration(const Subdomain& subdomain);
    // Finds what the program reads. Errors: it reads what only a lattice has.
    Result<void> start(Subdomain& subdomain, const world::World& world);
    // Touches of obstacles that began and ended; after each step.
    void note_obstacles(Subdomain& subdomain, std::span<const physics::TouchEvent> events);
    // After the last step of a tick: places, and all else that is read. Cost: one pass over the contacts where pressure is read,
    // and one over the catoms of the process, both on all workers; a few more instructions for catoms that are notified.
    void sense(Subdomain& subdomain, PhysicsScene& physics, const DividedBodies* divided);

  private:
    struct Sensor {
        BodySense sense;
        u32 predicate;  // That stores it.
        u64 dirty;      // What to mark at a catom that is notified.
        double threshold;
    };
    void find_sensor(const Subdomain& subdomain, const BodySense& sense);
    // Of this process's bodies; contacts at the border of the process are known to the process next to it.
    void sum_normal_forces(Subdomain& subdomain, const physics::Scene& scene, const DividedBodies* divided);
    // The next two may run on different workers for different catoms.
    // Places a catom and, if it is ours, writes what has changed by enough.
    void sense_catom(Subdomain& subdomain, const physics::Scene& scene, Catom catom, int worker) const;
    // Writes which of its features its neighbours touch, once all are placed.
    void write_contacts(Subdomain& subdomain, const PhysicsScene& physics, Catom catom, int worker) const;
    tuple::Numbers measure(const physics::Scene& scene, BodyQuantity quantity, physics::BodyId body, const physics::BodyState& state) const;
    static bool differs(const Sensor& sensor, const tuple::Numbers& last, const tuple::Numbers& now);

    const world::World* world_ = nullptr;
    std::vector<Sensor> sensors_;
    std::vector<ExactSum> normal_force_n_;              // By slot of the scene.
    std::optional<u32> touches_obstacle_, touches_at_;  // contact(A, Obstacle), contact(A, Other, Feature).
};

}  // namespace meld::sim
