// What catoms sense of what is ahead of them: range(A, Sensor, Metres), by the [[motion.sensor]]s of the world.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "physics/scene/scene.h"
#include "runtime/sim/bodies/senses/sensor_facts.h"
#include "runtime/sim/bodies/senses/surroundings.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class RangeFinders {
  public:
    explicit RangeFinders(const world::World& world);
    // Finds what the program reads. Errors: it reads ranges, and the world has no sensors.
    Result<void> start(const Subdomain& subdomain);
    // Whether somebody senses anything.
    bool active() const { return facts_.active(); }
    // From the surface of a body, m.
    double greatest_reach_m() const;
    // The catoms of this process sense what is ahead. A range that is known is written again once it has changed by more than the
    // threshold. An error is drawn anew in each tick; of a body that rests it is the same for the same range, so a run comes to rest.
    // Cost: a ray for each sensor of each catom, on all workers.
    void sense(Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings) const;

  private:
    struct Beam {
        physics::Vec3 direction;
        double reach_m = 0, noise_m = 0;
    };
    std::optional<double> measure(const Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings,
                                  std::uint64_t id, std::size_t beam) const;

    std::vector<Beam> beams_;
    double threshold_m_ = 0;
    SensorFacts facts_;
};

}  // namespace meld::sim
