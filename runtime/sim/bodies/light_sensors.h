// What catoms sense of light: light(A, Sensor, Irradiance), by the [[motion.sensor]]s of kind "light" and the lamps of the world.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/scene/scene.h"
#include "runtime/sim/bodies/lamps.h"
#include "runtime/sim/bodies/sensor_facts.h"
#include "runtime/sim/bodies/surroundings.h"
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
    // Cost: a look at each lamp for each sensor of each catom, and a ray for each lamp that may shine on it, on all workers.
    void sense(Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings,
               std::span<const Shining> lamps) const;

  private:
    struct Eye {
        physics::Vec3 direction;
        double noise_w_m2 = 0;
    };
    double measure(const Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings,
                   std::span<const Shining> lamps, std::uint64_t id, std::size_t sensor) const;

    std::vector<Eye> eyes_;
    double threshold_ = 0;  // A share of the former value.
    double least_distance_m_ = 0;
    SensorFacts facts_;
};

}  // namespace meld::sim
