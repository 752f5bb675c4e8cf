// What catoms sense of their bodies: written for programs that read it, once it has changed by more than a threshold.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "runtime/base/exact_sum.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/module/abi/senses.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/bodies/senses/sensor_facts.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// The predicate that stores what is sensed, if the program reads it. Where the program uses the word for something else: none.
std::optional<u32> stored(const Subdomain& subdomain, const BodySense& sense, PredicateKind kind = PredicateKind::Sensed);

// What the error of a measurement follows from besides the instrument: the tick; of a body that rests what is measured instead, so that the
// error stays the same while this does.
std::uint64_t when_measured(const physics::Scene& scene, physics::BodyId body, std::int64_t tick, std::uint64_t measured);

class BodySenses {
  public:
    // Whether the program senses accelerations, by either word.
    static bool senses_acceleration(const Subdomain& subdomain);
    // Finds which quantities the program reads. Errors: it reads one that only a lattice has, or temperatures where
    // nothing warms.
    Result<void> start(Subdomain& subdomain, const world::World& world);
    // Touches of obstacles that began and ended; call it after each step.
    void note_obstacles(Subdomain& subdomain, std::span<const physics::TouchEvent> events);
    bool senses_temperatures() const { return temperatures_.active(); }
    bool senses_connections() const { return connected_.has_value(); }
    // Two catoms of this process are connected from now on, or no longer.
    void note_connection(Subdomain& subdomain, physics::BodyId one, physics::BodyId other, bool holds) const;
    // After the last step of a tick: positions, and all other quantities that the program reads. Cost: one pass over the contacts if
    // pressure is read, and one over the catoms of the process, both on all workers; a few more instructions for catoms whose facts change.
    void sense(Subdomain& subdomain, PhysicsScene& physics, const DividedBodies* divided);

  private:
    struct Sensor {
        BodySense sense;
        u32 predicate;  // The predicate that stores it.
        u64 dirty;      // The bits to mark at a catom whose fact changes.
        double threshold;
    };
    void sense_temperatures(Subdomain& subdomain, const PhysicsScene& physics) const;
    void find_sensor(const Subdomain& subdomain, const BodySense& sense);
    // For this process's bodies; the neighbouring process knows the contacts at the border.
    void sum_normal_forces(Subdomain& subdomain, const physics::Scene& scene, const DividedBodies* divided);
    // Different workers may run the next two functions for different catoms.
    // Places a catom and, if it is ours, writes the quantities that have changed enough.
    void sense_catom(Subdomain& subdomain, const physics::Scene& scene, Catom catom, int worker) const;
    // Writes which of its features its neighbours touch, after all catoms are placed.
    void write_contacts(Subdomain& subdomain, const PhysicsScene& physics, Catom catom, int worker) const;
    tuple::Numbers measure(const Subdomain& subdomain, const physics::Scene& scene, BodyQuantity quantity, physics::BodyId body,
                           const physics::BodyState& state) const;
    static bool differs(const Sensor& sensor, const tuple::Numbers& last, const tuple::Numbers& now);

    const world::World* world_ = nullptr;
    std::vector<Sensor> sensors_;
    std::vector<ExactSum> normal_force_n_;              // By slot of the scene.
    std::optional<u32> touches_obstacle_, touches_at_;  // contact(A, Obstacle), contact(A, Other, Feature).
    std::optional<u32> connected_;                      // connected(A, Other).
    SensorFacts temperatures_;                          // coil(A, Feature, Kelvin).
};

}  // namespace meld::sim
