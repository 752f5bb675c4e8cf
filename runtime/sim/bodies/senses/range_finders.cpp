#include "runtime/sim/bodies/senses/range_finders.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "runtime/base/hash.h"
#include "runtime/sim/bodies/senses/body_senses.h"
#include "runtime/sim/core/sensor_noise.h"

namespace meld::sim {

RangeFinders::RangeFinders(const world::World& world) : threshold_m_(world.physics.sense.range * 2 * world.radius) {
    const double diameter_m = 2 * world.radius;
    for (const world::SensorOptions& sensor : world.physics.sensors) {
        if (sensor.kind != "range") continue;
        for (const world::Vec3& d : sensor.directions)
            beams_.push_back({{d[0], d[1], d[2]}, diameter_m * sensor.reach, diameter_m * sensor.noise});
    }
}

Result<void> RangeFinders::start(const Subdomain& subdomain) {
    facts_.start(subdomain, BodyQuantity::Range);
    if (!facts_.active() || !beams_.empty()) return {};
    return fail(fmt::format("{}: the program reads range(A, Sensor, Metres), and the world has no sensors", subdomain.world.path),
                "Write [[motion.sensor]] with directions = [[1, 0, 0]]");
}

double RangeFinders::greatest_reach_m() const {
    double reach_m = 0;
    for (const Beam& beam : beams_) reach_m = std::max(reach_m, beam.reach_m);
    return reach_m;
}

void RangeFinders::sense(Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings) const {
    facts_.sense(
        subdomain, beams_.size(),
        [&](Catom c, std::size_t sensor) { return measure(subdomain, scene, surroundings, subdomain.ensemble.id(c), sensor); },
        [&](double last, double now) { return std::abs(now - last) > threshold_m_; });
}

std::optional<double> RangeFinders::measure(const Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings,
                                            std::uint64_t id, std::size_t number) const {
    const Beam& beam = beams_[number];
    const physics::RayGrid::Thing& own = surroundings.body(id);
    // Orientations have unit length up to rounding.
    const physics::Vec3 turned = rotate(own.turn, beam.direction), along = (1 / length(turned)) * turned;
    const physics::Ray ray{own.centre + depth_along(own.shape, beam.direction) * along, beam.reach_m * along};
    const std::optional<double> met = surroundings.first_on(scene, id, ray);
    if (!met) return std::nullopt;
    const double metres = *met * beam.reach_m;
    if (beam.noise_m == 0) return metres;
    const std::uint64_t when =
        when_measured(scene, static_cast<physics::BodyId>(id), subdomain.tick(), std::bit_cast<std::uint64_t>(metres));
    return std::max(0.0,
                    metres + beam.noise_m * errors(subdomain.world.seed, NoiseStream::RangeFinders, hash_combine(id, number), when)[0]);
}

}  // namespace meld::sim
