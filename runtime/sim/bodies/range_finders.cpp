#include "runtime/sim/bodies/range_finders.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "runtime/base/hash.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/bodies/body_senses.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/core/sensor_noise.h"

namespace meld::sim {

namespace {

// Catoms that a worker takes at once: whole groups of the agenda.
constexpr Catom kCatomsOfRangeJob = 256;

}  // namespace

RangeFinders::RangeFinders(const world::World& world) : threshold_m_(world.physics.sense.range * 2 * world.radius) {
    const double diameter_m = 2 * world.radius;
    for (const world::SensorOptions& sensor : world.physics.sensors)
        for (const world::Vec3& d : sensor.directions)
            beams_.push_back({{d[0], d[1], d[2]}, diameter_m * sensor.reach, diameter_m * sensor.noise});
}

Result<void> RangeFinders::start(const Subdomain& subdomain) {
    for (const BodySense& sense : body_senses())
        if (sense.quantity == BodyQuantity::Range) predicate_ = stored(subdomain, sense);
    if (!predicate_) return {};
    if (beams_.empty())
        return fail(fmt::format("{}: the program reads range(A, Sensor, Metres), and the world has no sensors", subdomain.world.path),
                    "Write [[motion.sensor]] with directions = [[1, 0, 0]]");
    dirty_ = subdomain.module.columns[subdomain.module.predicates[*predicate_].column].own_dirty;
    return {};
}

double RangeFinders::greatest_reach_m() const {
    double reach_m = 0;
    for (const Beam& beam : beams_) reach_m = std::max(reach_m, beam.reach_m);
    return reach_m;
}

void RangeFinders::sense(Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings) const {
    const auto count = static_cast<Catom>(subdomain.ensemble.index_count());
    subdomain.workers.run((count + kCatomsOfRangeJob - 1) / kCatomsOfRangeJob, [&](int worker, std::size_t job) {
        const auto first = static_cast<Catom>(job) * kCatomsOfRangeJob;
        for (Catom c = first; c < std::min(count, first + kCatomsOfRangeJob); ++c)
            if (subdomain.owned(c) && sense_catom(subdomain, scene, surroundings, c, worker)) subdomain.mark_shared(c, dirty_);
    });
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

bool RangeFinders::sense_catom(Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings, Catom catom,
                               int worker) const {
    std::vector<std::optional<double>> last(beams_.size());
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), *predicate_, catom, [&](const Value* v) {
        const auto sensor = static_cast<std::size_t>(v[0].integer);
        if (sensor < last.size()) last[sensor] = v[1].real;
    });
    bool news = false;
    for (std::size_t i = 0; i < beams_.size(); ++i) {
        const std::optional<double> now = measure(subdomain, scene, surroundings, subdomain.ensemble.id(catom), i);
        if (now && last[i] && !(std::abs(*now - *last[i]) > threshold_m_)) continue;
        if (!now && !last[i]) continue;
        std::array<Value, 2> arguments{};
        arguments[0].integer = static_cast<i64>(i);
        if (last[i]) {
            arguments[1].real = *last[i];
            subdomain.take_shared(*predicate_, catom, arguments.data(), worker);
        }
        if (now) {
            arguments[1].real = *now;
            subdomain.give_shared(*predicate_, catom, arguments.data(), worker);
        }
        news = true;
    }
    return news;
}

}  // namespace meld::sim
