#include "runtime/sim/bodies/senses/light_sensors.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "runtime/base/hash.h"
#include "runtime/sim/bodies/senses/body_senses.h"
#include "runtime/sim/core/sensor_noise.h"

namespace meld::sim {

namespace {

// No lamp is a point: those that are nearer than this share of a diameter count as if they were so far away.
constexpr double kLeastDistanceShare = 0.01;
// A sensor looks from this share of its body's radius above the surface, so that rounding does not put it below that.
constexpr double kLiftShare = 1e-6;

// A sensor on its body.
struct Mounted {
    std::uint64_t id = 0;
    physics::Vec3 place_m, along, lifted_m;
};

Mounted mounted(const physics::RayGrid::Thing& body, std::uint64_t id, physics::Vec3 direction) {
    // Orientations have unit length up to rounding.
    const physics::Vec3 turned = rotate(body.turn, direction), along = (1 / length(turned)) * turned;
    const physics::Vec3 place_m = body.centre + depth_along(body.shape, direction) * along;
    return {id, place_m, along, place_m + kLiftShare * body.shape.radius_m() * along};
}

// Whether the light of a lamp gets to a sensor: another body, an obstacle, or the sensor's own body may be in its way.
bool is_lit(const physics::Scene& scene, const BodySurroundings& surroundings, const Mounted& sensor, const Shining& lamp) {
    const physics::Ray ray{sensor.lifted_m, lamp.place_m - sensor.lifted_m};
    const physics::RayGrid::Thing& own = surroundings.body(sensor.id);
    if (physics::first_on(own.shape, own.centre, own.turn, ray)) return false;
    return surroundings.is_free(scene, sensor.id, lamp.body ? std::optional<std::uint64_t>(*lamp.body) : std::nullopt, ray);
}

}  // namespace

LightSensors::Lit::Lit(std::span<const Shining> all) : lamps(all) {
    for (const Shining& lamp : lamps) reaching.add(lamp.place_m, lamp.reach_m);
    reaching.sort();
}

LightSensors::LightSensors(const world::World& world)
    : threshold_(world.physics.sense.light), least_distance_m_(kLeastDistanceShare * 2 * world.radius) {
    for (const world::SensorOptions& sensor : world.physics.sensors) {
        if (sensor.kind != "light") continue;
        for (const world::Vec3& d : sensor.directions) eyes_.push_back({{d[0], d[1], d[2]}, sensor.noise});
    }
}

Result<void> LightSensors::start(const Subdomain& subdomain) {
    facts_.start(subdomain, BodyQuantity::Light);
    if (!facts_.active() || !eyes_.empty()) return {};
    return fail(fmt::format("{}: the program reads light(A, Sensor, Irradiance), and the world has no light sensors", subdomain.world.path),
                "Write [[motion.sensor]] with kind = \"light\" and directions = [[1, 0, 0]]");
}

void LightSensors::sense(Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings,
                         std::span<const Shining> lamps) const {
    const Lit lit(lamps);
    facts_.sense(
        subdomain, eyes_.size(),
        [&](Catom c, std::size_t sensor) { return measure(subdomain, scene, surroundings, lit, subdomain.ensemble.id(c), sensor); },
        [&](double last, double now) { return std::abs(now - last) > threshold_ * std::abs(last); });
}

// Of an isotropic lamp, power / (4 pi r^2) goes through an area that faces it, and less by the cosine (Lambert) through one that does not.
double LightSensors::measure(const Subdomain& subdomain, const physics::Scene& scene, const BodySurroundings& surroundings, const Lit& lit,
                             std::uint64_t id, std::size_t number) const {
    const Eye& eye = eyes_[number];
    const Mounted sensor = mounted(surroundings.body(id), id, eye.direction);
    thread_local std::vector<std::uint32_t> near;
    lit.reaching.find(sensor.place_m, near);
    double sum_w_m2 = 0;
    for (const std::uint32_t lamp_number : near) {
        const Shining& lamp = lit.lamps[lamp_number];
        const physics::Vec3 way = lamp.place_m - sensor.place_m;
        const double ahead_m = dot(way, sensor.along), distance_m = length(way);
        if (!(ahead_m > 0) || distance_m > lamp.reach_m || !is_lit(scene, surroundings, sensor, lamp)) continue;
        const double far_m = std::max(distance_m, least_distance_m_);
        sum_w_m2 += lamp.power_w / (4 * std::numbers::pi * far_m * far_m) * (ahead_m / distance_m);
    }
    if (eye.noise_w_m2 == 0) return sum_w_m2;
    const std::uint64_t when =
        when_measured(scene, static_cast<physics::BodyId>(id), subdomain.tick(), std::bit_cast<std::uint64_t>(sum_w_m2));
    const double error = errors(subdomain.world.seed, NoiseStream::LightSensors, hash_combine(id, number), when)[0];
    return std::max(0.0, sum_w_m2 + eye.noise_w_m2 * error);
}

}  // namespace meld::sim
