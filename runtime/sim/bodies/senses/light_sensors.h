// What catoms sense of light: light(A, Sensor, Irradiance), by the [[motion.sensor]]s of kind "light" and the lamps of the world.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/collision/reach_grid.h"
#include "physics/scene/scene.h"
#include "runtime/sim/bodies/senses/lamps.h"
#include "runtime/sim/bodies/senses/sensor_facts.h"
#include "runtime/sim/bodies/senses/surroundings.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class LightSensors {
  public:
    explicit LightSensors(const world::World& world);
    // Finds what the program reads. Errors: it reads light, and the world has no sensors for it.
    Result<void> start(const Subdomain& subdomain);
    // Whether somebody senses anything.
    bool active() const { return facts_.active(); }
    // The catoms of this process sense what the lamps shine on them. What is known is written again once it has changed by more than the
    // threshold. An error is drawn anew in each tick; of a body that rests it is the same for the same light, so a run comes to rest.
    // Cost: sorting all lamps; for each sensor of each catom a look at the lamps that reach about as far as it, and a ray to each that may
    // shine on it, on all workers. Lamps without a reach reach all.
    void sense(Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings,
               std::span<const Shining> lamps) const;

  private:
    struct Eye {
        physics::Vec3 direction;
        double noise_w_m2 = 0;
    };
    // The lamps, and which of them reach a place.
    struct Lit {
        explicit Lit(std::span<const Shining> all);
        std::span<const Shining> lamps;
        physics::ReachGrid reaching;
    };
    double measure(const Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings, const Lit& lit,
                   std::uint64_t id, std::size_t sensor) const;

    std::vector<Eye> eyes_;
    double threshold_ = 0;  // A share of the former value.
    double least_distance_m_ = 0;
    SensorFacts facts_;
};

}  // namespace meld::sim
