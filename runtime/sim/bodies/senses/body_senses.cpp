#include "runtime/sim/bodies/senses/body_senses.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"
#include "runtime/sim/core/sensor_noise.h"

namespace meld::sim {

namespace {

// Whole bricks of the ensemble, so that one worker writes all target bits of a brick.
constexpr Catom kCatomsOfSenseJob = 64 * (kBrickCells / kMaxPorts);

double threshold_of(BodyQuantity quantity, const world::SenseOptions& sense) {
    switch (quantity) {
        case BodyQuantity::Orientation:
            return sense.orientation;
        case BodyQuantity::Velocity:
            return sense.velocity;
        case BodyQuantity::Acceleration:
            return sense.acceleration;
        case BodyQuantity::Gyro:
            return sense.gyro;
        case BodyQuantity::Accelerometer:
            return sense.accelerometer;
        case BodyQuantity::Pressure:
            return sense.pressure;
        case BodyQuantity::Energy:
            return sense.energy;
        case BodyQuantity::Load:
            return sense.load;
        case BodyQuantity::Obstacle:
        case BodyQuantity::Contact:
        case BodyQuantity::Connected:
        case BodyQuantity::Broke:
        case BodyQuantity::Joint:
        case BodyQuantity::Range:
        case BodyQuantity::Light:
        case BodyQuantity::Temperature:
            break;
    }
    MELD_CHECK(false, "touches have no threshold");
}

double square_distance(const world::Vec3& a, const world::Vec3& b) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
}

// The feature that points most nearly in a direction, in the body's frame.
std::int64_t nearest_feature(const std::vector<physics::Feature>& features, physics::Vec3 direction) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < features.size(); ++i)
        if (dot(features[i].direction, direction) > dot(features[best].direction, direction)) best = i;
    return static_cast<std::int64_t>(best);
}

std::uint64_t hashed(physics::Vec3 v) {
    std::uint64_t hash = 0;
    for (const double x : {v.x, v.y, v.z}) hash = hash_combine(hash, std::bit_cast<std::uint64_t>(x + 0.0));
    return hash;
}

// Whether two bodies at this distance in diameters touch.
bool touches(const PhysicsScene& physics, const world::World& world, u64 one, u64 other, double diameters) {
    const physics::Scene& scene = *physics.scene;
    const auto a = static_cast<physics::BodyId>(one), b = static_cast<physics::BodyId>(other);
    if (!scene.has(a) || !scene.has(b)) return false;
    return diameters * 2 * world.radius < scene.radius(a) + scene.radius(b) + physics.touch_m && scene.nearer(a, b, physics.touch_m);
}

}  // namespace

std::uint64_t when_measured(const physics::Scene& scene, physics::BodyId body, std::int64_t tick, std::uint64_t measured) {
    const auto still = [&] {
        const physics::BodyState state = scene.state(body);
        return state.linear_velocity_m_s == physics::Vec3{} && state.angular_velocity_rad_s == physics::Vec3{};
    };
    const bool rests = scene.asleep(body) || (scene.fixed(body) && still());
    return rests ? hash_combine(1, measured) : hash_combine(0, static_cast<std::uint64_t>(tick));
}

std::optional<u32> stored(const Subdomain& subdomain, const BodySense& sense, PredicateKind kind) {
    const ModuleInfo& module = subdomain.module;
    const std::optional<u32> p = tuple::find_predicate(module, sense.word, sense.arguments);
    if (!p || module.predicates[*p].kind != kind || module.predicates[*p].base == kNone16) return std::nullopt;
    const u16 base = module.predicates[*p].base;
    return module.predicates[base].column == kNone16 ? std::nullopt : std::optional<u32>(base);
}

void BodySenses::find_sensor(const Subdomain& subdomain, const BodySense& sense) {
    const std::optional<u32> base = stored(subdomain, sense);
    if (!base) return;
    if (sense.quantity == BodyQuantity::Obstacle)
        touches_obstacle_ = base;
    else if (sense.quantity == BodyQuantity::Contact)
        touches_at_ = base;
    else if (sense.quantity == BodyQuantity::Connected)
        connected_ = base;
    else if (sense.quantity != BodyQuantity::Load && sense.quantity != BodyQuantity::Joint && sense.quantity != BodyQuantity::Range &&
             sense.quantity != BodyQuantity::Light && sense.quantity != BodyQuantity::Temperature)
        sensors_.push_back({sense, *base, subdomain.module.columns[subdomain.module.predicates[*base].column].own_dirty,
                            threshold_of(sense.quantity, world_->physics.sense)});
}

bool BodySenses::senses_acceleration(const Subdomain& subdomain) {
    return std::ranges::any_of(body_senses(), [&](const BodySense& sense) {
        return (sense.quantity == BodyQuantity::Acceleration || sense.quantity == BodyQuantity::Accelerometer) && stored(subdomain, sense);
    });
}

Result<void> BodySenses::start(Subdomain& subdomain, const world::World& world) {
    world_ = &world;
    const auto reads = [&](std::string_view name, std::size_t arity) {
        const std::optional<u32> p = tuple::find_sensed(subdomain.module, name, arity);
        return p && subdomain.module.predicates[*p].storage == Storage::World && subdomain.module.predicates[*p].read;
    };
    for (const auto& [name, arity, source] : sense_names())
        if (info(source).has(SenseInfo::kCells) && reads(name, arity))
            return fail(fmt::format("the program reads {} with {} arguments, and catoms that move freely have no cells", name, arity + 1),
                        "Read position, or give the world [motion] kind = \"lattice\"");
    for (const BodySense& sense : body_senses()) find_sensor(subdomain, sense);
    temperatures_.start(subdomain, BodyQuantity::Temperature);
    if (!temperatures_.active() || std::ranges::any_of(world.physics.features, &world::FeatureOptions::warms)) return {};
    return fail(fmt::format("{}: the program reads coil(A, Feature, Kelvin), and no magnet of the world has a coil that warms", world.path),
                "Write [[motion.feature]] with current, resistance, thermal_resistance and cooling");
}

void BodySenses::note_obstacles(Subdomain& subdomain, std::span<const physics::TouchEvent> events) {
    if (!touches_obstacle_) return;
    for (const physics::TouchEvent& e : events) {
        if (!e.touch.other_is_obstacle) continue;
        Value obstacle{};
        obstacle.integer = e.touch.other;
        const Catom catom = *subdomain.ensemble.find(e.touch.body);
        if (e.began)
            subdomain.give(*touches_obstacle_, catom, &obstacle);
        else
            subdomain.take(*touches_obstacle_, catom, &obstacle);
    }
}

void BodySenses::note_connection(Subdomain& subdomain, physics::BodyId one, physics::BodyId other, bool holds) const {
    if (!connected_) return;
    for (const auto& [at, to] : {std::pair{one, other}, std::pair{other, one}}) {
        const std::optional<Catom> catom = subdomain.ensemble.find(at);
        // All processes know all connections.
        if (!catom || !subdomain.owned(*catom)) continue;
        Value value{};
        value.catom = to;
        if (holds)
            subdomain.give(*connected_, *catom, &value);
        else
            subdomain.take(*connected_, *catom, &value);
    }
}

void BodySenses::sense(Subdomain& subdomain, PhysicsScene& physics, const DividedBodies* divided) {
    if (std::any_of(sensors_.begin(), sensors_.end(), [](const Sensor& s) { return s.sense.quantity == BodyQuantity::Pressure; }))
        sum_normal_forces(subdomain, *physics.scene, divided);
    const auto count = static_cast<Catom>(subdomain.ensemble.index_count());
    const auto each_catom = [&](const auto& visit) {
        subdomain.workers.run((count + kCatomsOfSenseJob - 1) / kCatomsOfSenseJob, [&](int worker, std::size_t job) {
            const auto first = static_cast<Catom>(job) * kCatomsOfSenseJob;
            for (Catom c = first; c < std::min(count, first + kCatomsOfSenseJob); ++c) visit(worker, c);
        });
    };
    each_catom([&](int worker, Catom c) { sense_catom(subdomain, *physics.scene, c, worker); });
    if (temperatures_.active()) sense_temperatures(subdomain, physics);
    if (!touches_at_ || physics.features.empty()) return;
    each_catom([&](int worker, Catom c) {
        if (subdomain.owned(c)) write_contacts(subdomain, physics, c, worker);
    });
}

void BodySenses::sense_temperatures(Subdomain& subdomain, const PhysicsScene& physics) const {
    temperatures_.sense(
        subdomain, physics.features.size(),
        [&](Catom c, std::size_t feature) -> std::optional<double> {
            if (physics.features[feature].thermal_resistance_k_w == 0) return std::nullopt;
            return physics.scene->temperature_k(static_cast<physics::BodyId>(subdomain.ensemble.id(c)), feature);
        },
        [&](double last, double now) { return std::abs(now - last) > world_->physics.sense.temperature; });
}

void BodySenses::sum_normal_forces(Subdomain& subdomain, const physics::Scene& scene, const DividedBodies* divided) {
    scene.sum_normal_forces(normal_force_n_, subdomain.workers);
    if (divided != nullptr) divided->complete(subdomain, normal_force_n_);
}

void BodySenses::sense_catom(Subdomain& subdomain, const physics::Scene& scene, Catom catom, int worker) const {
    MELD_EXPECT(catom < subdomain.ensemble.index_count(), "catom {} of {}", catom, subdomain.ensemble.index_count());
    if (subdomain.ensemble.state(catom) == kCatomFree) return;
    const auto body = static_cast<physics::BodyId>(subdomain.ensemble.id(catom));
    // A neighbour within the range may be farther away than the bodies that this process has.
    if (!subdomain.owned(catom) && !scene.has(body)) return;
    const physics::BodyState state = scene.state(body);
    const world::Vec3 here = to_diameters(*world_, state.position_m);
    u64 news = 0;
    if (subdomain.place(catom, here)) news |= kDirtyPlace;
    if (!subdomain.owned(catom)) return;
    const double enough = world_->physics.sense.position;
    if (subdomain.senses_positions() && square_distance(here, subdomain.sensed_position(catom)) > enough * enough) {
        subdomain.sense_position(catom, here);
        news |= kDirtyPlace;
    }
    for (const Sensor& sensor : sensors_) {
        const tuple::Numbers now = measure(subdomain, scene, sensor.sense.quantity, body, state);
        if (!differs(sensor, tuple::read_numbers(subdomain.module, subdomain.columns, sensor.predicate, catom), now)) continue;
        subdomain.give_numbers(sensor.predicate, catom, now, worker);
        news |= sensor.dirty;
    }
    if (news != 0) subdomain.mark_shared(catom, news);
}

tuple::Numbers BodySenses::measure(const Subdomain& subdomain, const physics::Scene& scene, BodyQuantity quantity, physics::BodyId body,
                                   const physics::BodyState& state) const {
    const auto numbers = [](physics::Vec3 v) { return tuple::Numbers{{v.x, v.y, v.z, 0}, 3}; };
    // What an instrument on the body shows, whose axes turn with it.
    const auto shown = [&](physics::Vec3 v, NoiseStream stream, double noise) {
        v = rotate(conjugate(state.orientation), v);
        if (noise > 0) {
            const std::uint64_t when = when_measured(scene, body, subdomain.tick(), hashed(v));
            const auto [x, y] = errors(world_->seed, stream, body, when);
            v = v + noise * physics::Vec3{x, y, errors(world_->seed, stream, body, when + 2)[0]};
        }
        return numbers(v);
    };
    switch (quantity) {
        case BodyQuantity::Orientation:
            return {{state.orientation.w, state.orientation.x, state.orientation.y, state.orientation.z}, 4};
        case BodyQuantity::Velocity:
            return numbers(state.linear_velocity_m_s);
        case BodyQuantity::Acceleration:
            return numbers(scene.acceleration(body));
        case BodyQuantity::Gyro:
            return shown(state.angular_velocity_rad_s, NoiseStream::Gyros, world_->physics.noise.gyro);
        case BodyQuantity::Accelerometer:
            return shown(scene.acceleration(body) - scene.gravity_m_s2(), NoiseStream::Accelerometers, world_->physics.noise.accelerometer);
        case BodyQuantity::Pressure:
            return {{normal_force_n_[scene.slot(body)].value() / scene.surface_m2(body), 0, 0, 0}, 1};
        case BodyQuantity::Energy:
            return {{scene.energy_drawn_j(body), 0, 0, 0}, 1};
        case BodyQuantity::Obstacle:
        case BodyQuantity::Contact:
        case BodyQuantity::Connected:
        case BodyQuantity::Load:
        case BodyQuantity::Broke:
        case BodyQuantity::Joint:
        case BodyQuantity::Range:
        case BodyQuantity::Light:
        case BodyQuantity::Temperature:
            break;
    }
    MELD_CHECK(false, "touches are not measured");
}

bool BodySenses::differs(const Sensor& sensor, const tuple::Numbers& last, const tuple::Numbers& now) {
    if (last.count == 0) return true;
    if (sensor.sense.change == BodySense::Change::Share) return std::abs(now.at[0] - last.at[0]) > sensor.threshold * std::abs(last.at[0]);
    if (sensor.sense.change == BodySense::Change::Angle) {
        // The cosine of half the angle between two rotations.
        const double cosine = std::abs(now.at[0] * last.at[0] + now.at[1] * last.at[1] + now.at[2] * last.at[2] + now.at[3] * last.at[3]);
        return 2 * std::acos(std::min(1.0, cosine)) > sensor.threshold;
    }
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += (now.at[i] - last.at[i]) * (now.at[i] - last.at[i]);
    return sum > sensor.threshold * sensor.threshold;
}

// Which feature each neighbour touches most nearly: takes back facts of neighbours that have gone or rolled on.
void BodySenses::write_contacts(Subdomain& subdomain, const PhysicsScene& physics, Catom catom, int worker) const {
    std::vector<std::pair<u64, i64>> last, now;
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), *touches_at_, catom,
                     [&](const Value* v) { last.emplace_back(v[0].catom, v[1].integer); });
    const physics::Quat turned = conjugate(physics.scene->state(static_cast<physics::BodyId>(subdomain.ensemble.id(catom))).orientation);
    const world::Vec3 here = subdomain.ensemble.position(catom);
    subdomain.each_neighbour(catom, [&](Catom other) {
        const world::Vec3 there = subdomain.ensemble.position(other);
        const physics::Vec3 way = {there[0] - here[0], there[1] - here[1], there[2] - here[2]};
        if (world_->links && !touches(physics, *world_, subdomain.ensemble.id(catom), subdomain.ensemble.id(other), length(way))) return;
        now.emplace_back(subdomain.ensemble.id(other), nearest_feature(physics.features, rotate(turned, way)));
    });
    std::sort(last.begin(), last.end());
    std::sort(now.begin(), now.end());
    if (last == now) return;
    const auto values = [](const std::pair<u64, i64>& fact) {
        std::array<Value, 2> v{};
        v[0].catom = fact.first;
        v[1].integer = fact.second;
        return v;
    };
    for (const auto& fact : last)
        if (!std::binary_search(now.begin(), now.end(), fact)) subdomain.take_shared(*touches_at_, catom, values(fact).data(), worker);
    for (const auto& fact : now)
        if (!std::binary_search(last.begin(), last.end(), fact)) subdomain.give_shared(*touches_at_, catom, values(fact).data(), worker);
    subdomain.mark_shared(catom, subdomain.module.columns[subdomain.module.predicates[*touches_at_].column].own_dirty);
}

}  // namespace meld::sim
