#include "runtime/sim/body_senses.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "runtime/sim/bytes.h"
#include "runtime/tuple/facts.h"

namespace meld::sim {

namespace {

// Whole bricks of the ensemble, whose bits for the target one worker writes.
constexpr Catom kCatomsOfJob = 64 * (kBrickCells / kMaxPorts);

std::optional<u32> stored(const PartState& part, const char* name, std::size_t arity) {
    const std::optional<u32> p = tuple::find_sensed(part.module, name, arity);
    if (!p || part.module.predicates[*p].base == kNone16) return std::nullopt;
    const u16 base = part.module.predicates[*p].base;
    return part.module.predicates[base].column == kNone16 ? std::nullopt : std::optional<u32>(base);
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

}  // namespace

void BodySenses::find_sensor(const PartState& part, const char* name, std::size_t arity, Quantity quantity, double threshold) {
    if (const auto base = stored(part, name, arity)) sensors_.push_back({quantity, *base, part.module.predicates[*base].fields[0].type == ValueType::Vec3, threshold});
}

bool BodySenses::feels_acceleration(const PartState& part) { return stored(part, "acceleration", 1) || stored(part, "acceleration", 3); }

Result<void> BodySenses::start(PartState& part, const world::World& world) {
    world_ = &world;
    const world::SenseOptions& s = world.physics.sense;
    const auto reads = [&](const char* name, std::size_t arity) {
        const std::optional<u32> p = tuple::find_sensed(part.module, name, arity);
        return p && part.module.predicates[*p].storage == Storage::World && part.module.predicates[*p].read;
    };
    const std::pair<const char*, std::size_t> of_lattices[] = {{"cell", 3}, {"vacant", 1}, {"target", 1}};
    for (const auto& [name, arity] : of_lattices)
        if (reads(name, arity))
            return fail(fmt::format("the program reads {} with {} arguments, and catoms that move freely have no cells", name, arity + 1),
                        "Read position, or give the world [motion] kind = \"lattice\"");
    find_sensor(part, "orientation", 4, Quantity::Orientation, s.orientation);
    for (const std::size_t arity : {std::size_t{1}, std::size_t{3}}) {
        find_sensor(part, "velocity", arity, Quantity::Velocity, s.velocity);
        find_sensor(part, "acceleration", arity, Quantity::Acceleration, s.acceleration);
    }
    find_sensor(part, "pressure", 1, Quantity::Pressure, s.pressure);
    find_sensor(part, "energy", 1, Quantity::Energy, s.energy);
    touches_obstacle_ = stored(part, "contact", 1);
    touches_at_ = stored(part, "contact", 2);
    return {};
}

void BodySenses::note_obstacles(PartState& part, std::span<const physics::TouchEvent> events) {
    if (!touches_obstacle_) return;
    for (const physics::TouchEvent& e : events) {
        if (!e.touch.other_is_obstacle) continue;
        Value obstacle{};
        obstacle.integer = e.touch.other;
        const Catom catom = *part.ensemble.find(e.touch.body);
        if (e.began) part.give(*touches_obstacle_, catom, &obstacle);
        else part.take(*touches_obstacle_, catom, &obstacle);
    }
}

void BodySenses::place(PartState& part, const physics::Scene& scene, Catom first, Catom last, std::vector<Moved>& moved) {
    const double enough = world_->physics.sense.position * world_->physics.sense.position;
    for (Catom c = first; c < last; ++c) {
        if (part.ensemble.state(c) == kCatomFree) continue;
        const world::Vec3 now = to_diameters(*world_, scene.state(static_cast<physics::BodyId>(part.ensemble.id(c))).position_m);
        const bool entered = part.ensemble.place(c, now);
        if (!part.owned(c)) continue;
        const bool far = part.reads_places && square_distance(now, part.sensed_positions[c]) > enough;
        if (far) part.sensed_positions[c] = now;
        if (far || entered) moved.push_back({c, true});
    }
}

void BodySenses::sum_normal_forces(PartState& part, physics::Scene& scene, const DividedBodies* divided) {
    struct Press {
        physics::BodyId body;
        double force_n;
    };
    normal_force_n_.assign(scene.slot_count(), {});
    std::vector<std::vector<std::byte>> out(static_cast<std::size_t>(part.comm.parts()));
    const auto press = [&](physics::BodyId body, double force_n) {
        const int owner = divided != nullptr ? divided->owner_of(body) : part.comm.part();
        if (owner == part.comm.part()) normal_force_n_[scene.slot(body)].add(force_n);
        else put(out[static_cast<std::size_t>(owner)], Press{body, force_n});
    };
    scene.each_contact([&](const physics::ContactReport& c) {
        if (!(c.normal_force_n > 0)) return;
        press(c.touch.body, c.normal_force_n);
        if (!c.touch.other_is_obstacle) press(c.touch.other, c.normal_force_n);
    });
    if (divided == nullptr) return;
    for (const comm::Packet& packet : exchange_bytes(part, out))
        for (const std::byte* at = packet.bytes.data(); at != packet.bytes.data() + packet.bytes.size();) {
            const auto theirs = take_value<Press>(at);
            normal_force_n_[scene.slot(theirs.body)].add(theirs.force_n);
        }
}

void BodySenses::sense(PartState& part, PhysicsScene& physics, const DividedBodies* divided) {
    const auto count = static_cast<Catom>(part.ensemble.index_count());
    std::vector<std::vector<Moved>> moved((count + kCatomsOfJob - 1) / kCatomsOfJob);
    part.workers.run(moved.size(), [&](int, std::size_t job) {
        const auto first = static_cast<Catom>(job) * kCatomsOfJob;
        place(part, *physics.scene, first, std::min(count, first + kCatomsOfJob), moved[job]);
    });
    for (const auto& list : moved)
        for (const Moved& m : list) part.mark(m.catom, kDirtyPlace);
    if (sensors_.empty() && !touches_at_) return;
    const bool presses = std::any_of(sensors_.begin(), sensors_.end(), [](const Sensor& s) { return s.quantity == Quantity::Pressure; });
    if (presses) sum_normal_forces(part, *physics.scene, divided);
    tell_changes(part, *physics.scene);
    if (!touches_at_ || physics.features.empty()) return;
    for (Catom c = 0; c < count; ++c)
        if (part.owned(c)) tell_contacts(part, physics, c);
}

void BodySenses::tell_changes(PartState& part, const physics::Scene& scene) {
    struct Change {
        Catom catom;
        const Sensor* sensor;
        Numbers now;
    };
    const auto count = static_cast<Catom>(part.ensemble.index_count());
    std::vector<std::vector<Change>> changes((count + kCatomsOfJob - 1) / kCatomsOfJob);
    part.workers.run(changes.size(), [&](int, std::size_t job) {
        const auto first = static_cast<Catom>(job) * kCatomsOfJob;
        for (Catom c = first; c < std::min(count, first + kCatomsOfJob); ++c) {
            if (!part.owned(c)) continue;
            const auto body = static_cast<physics::BodyId>(part.ensemble.id(c));
            for (const Sensor& sensor : sensors_)
                if (const Numbers now = measure(scene, sensor.quantity, body); differs(sensor, told(part, sensor, c), now)) changes[job].push_back({c, &sensor, now});
        }
    });
    for (const auto& list : changes)
        for (const Change& change : list) tell(part, *change.sensor, change.catom, change.now);
}

BodySenses::Numbers BodySenses::measure(const physics::Scene& scene, Quantity quantity, physics::BodyId body) const {
    const auto numbers = [](physics::Vec3 v) { return Numbers{{v.x, v.y, v.z, 0}, 3}; };
    switch (quantity) {
        case Quantity::Orientation: {
            const physics::Quat q = scene.state(body).orientation;
            return {{q.w, q.x, q.y, q.z}, 4};
        }
        case Quantity::Velocity: return numbers(scene.state(body).velocity_m_s);
        case Quantity::Acceleration: return numbers(scene.acceleration(body));
        case Quantity::Pressure: return {{normal_force_n_[scene.slot(body)].value() / (4 * std::numbers::pi * scene.radius(body) * scene.radius(body)), 0, 0, 0}, 1};
        case Quantity::Energy: return {{scene.energy_drawn_j(body), 0, 0, 0}, 1};
    }
    return {};
}

bool BodySenses::differs(const Sensor& sensor, const Numbers& told, const Numbers& now) {
    if (told.count == 0) return true;
    if (sensor.quantity == Quantity::Pressure || sensor.quantity == Quantity::Energy)
        return std::abs(now.at[0] - told.at[0]) > sensor.threshold * std::abs(told.at[0]);
    if (sensor.quantity == Quantity::Orientation) {
        // Half the angle between two rotations has this cosine.
        const double cosine = std::abs(now.at[0] * told.at[0] + now.at[1] * told.at[1] + now.at[2] * told.at[2] + now.at[3] * told.at[3]);
        return 2 * std::acos(std::min(1.0, cosine)) > sensor.threshold;
    }
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += (now.at[i] - told.at[i]) * (now.at[i] - told.at[i]);
    return sum > sensor.threshold * sensor.threshold;
}

BodySenses::Numbers BodySenses::told(const PartState& part, const Sensor& sensor, Catom catom) const {
    Numbers found;
    tuple::each_fact(part.module, part.columns, part.abi.geometry, sensor.predicate, catom, [&](const Value* v) {
        found.count = sensor.vector ? 3 : part.module.predicates[sensor.predicate].arity;
        for (std::size_t i = 0; i < found.count; ++i) found.at[i] = sensor.vector ? tuple::item(v[0].list, i).real : v[i].real;
    });
    return found;
}

void BodySenses::tell(PartState& part, const Sensor& sensor, Catom catom, const Numbers& now) {
    std::array<Value, 4> values{};
    for (std::size_t i = 0; i < now.count; ++i) values[i].real = now.at[i] + 0.0;
    if (!sensor.vector) {
        part.give(sensor.predicate, catom, values.data());
        return;
    }
    u64 items[3];
    for (std::size_t i = 0; i < 3; ++i) items[i] = static_cast<u64>(values[i].integer);
    const List list{items, 3, 0};
    Value value{};
    value.list = &list;
    part.give(sensor.predicate, catom, &value);
}

// Which feature each neighbour touches nearest to: facts of those that are gone or have rolled on are taken back.
void BodySenses::tell_contacts(PartState& part, PhysicsScene& physics, Catom catom) {
    std::vector<std::pair<u64, i64>> told, now;
    tuple::each_fact(part.module, part.columns, part.abi.geometry, *touches_at_, catom, [&](const Value* v) { told.emplace_back(v[0].catom, v[1].integer); });
    const physics::Quat turned = conjugate(physics.scene->state(static_cast<physics::BodyId>(part.ensemble.id(catom))).orientation);
    const world::Vec3 here = part.ensemble.position(catom);
    for (int port = 0; port < kMaxPorts; ++port) {
        const std::optional<Catom> other = part.ensemble.linked(catom, port);
        if (!other) continue;
        const world::Vec3 there = part.ensemble.position(*other);
        const physics::Vec3 towards = rotate(turned, {there[0] - here[0], there[1] - here[1], there[2] - here[2]});
        now.emplace_back(part.ensemble.id(*other), nearest_feature(physics.features, towards));
    }
    std::sort(told.begin(), told.end());
    std::sort(now.begin(), now.end());
    if (told == now) return;
    const auto values = [](const std::pair<u64, i64>& fact) {
        std::array<Value, 2> v{};
        v[0].catom = fact.first;
        v[1].integer = fact.second;
        return v;
    };
    for (const auto& fact : told)
        if (!std::binary_search(now.begin(), now.end(), fact)) part.take(*touches_at_, catom, values(fact).data());
    for (const auto& fact : now)
        if (!std::binary_search(told.begin(), told.end(), fact)) part.give(*touches_at_, catom, values(fact).data());
}

}  // namespace meld::sim
