#include "runtime/sim/points/range_senses.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/engine/tuple/values.h"
#include "runtime/sim/core/sensor_noise.h"

namespace meld::sim {

namespace {

// Nodes that a worker takes at once: whole groups of the agenda.
constexpr Catom kCatomsOfJob = 1024;

// Of a measurement between two nodes: by the two in this order, and how they lie.
std::array<double, 2> errors_between(std::uint64_t seed, NoiseStream stream, std::uint64_t here, std::uint64_t there,
                                     const world::Vec3& way) {
    std::uint64_t lie = 0;
    for (const double x : way) lie = hash_combine(lie, std::bit_cast<std::uint64_t>(x + 0.0));
    return errors(seed, stream, hash_combine(here, there), lie);
}

double length_of(const world::Vec3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

// A unit vector, turned in the plane if it lies there, and otherwise by two angles at right angles to it and each other.
world::Vec3 turned(const world::Vec3& v, double one, double other) {
    if (v[2] == 0) return {v[0] * std::cos(one) - v[1] * std::sin(one), v[0] * std::sin(one) + v[1] * std::cos(one), 0};
    // A direction at a right angle: across the axis along which v is shortest.
    std::size_t least = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if (std::abs(v[i]) < std::abs(v[least])) least = i;
    world::Vec3 axis{};
    axis[least] = 1;
    const auto cross = [](const world::Vec3& a, const world::Vec3& b) {
        return world::Vec3{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    world::Vec3 side = cross(v, axis);
    const double length = length_of(side);
    for (double& x : side) x /= length;
    const world::Vec3 up = cross(v, side);
    const double angle = std::hypot(one, other);
    if (angle == 0) return v;
    world::Vec3 out{};
    for (std::size_t i = 0; i < 3; ++i) out[i] = std::cos(angle) * v[i] + std::sin(angle) * (one / angle * side[i] + other / angle * up[i]);
    return out;
}

// What is sensed, if the program reads it.
std::optional<u32> stored(const Subdomain& subdomain, const RangeSense& sense) {
    const std::optional<u32> p = tuple::find_sensed(subdomain.module, sense.word, sense.arguments);
    if (!p || subdomain.module.predicates[*p].base == kNone16) return std::nullopt;
    const u16 base = subdomain.module.predicates[*p].base;
    return subdomain.module.predicates[base].column == kNone16 ? std::nullopt : std::optional<u32>(base);
}

}  // namespace

void RangeSenses::start(const Subdomain& subdomain) {
    for (const RangeSense& sense : range_senses())
        if (const std::optional<u32> base = stored(subdomain, sense))
            sensors_.push_back({.quantity = sense.quantity,
                                .predicate = *base,
                                .dirty = subdomain.module.columns[subdomain.module.predicates[*base].column].own_dirty});
}

void RangeSenses::sense(Subdomain& subdomain) const {
    if (sensors_.empty()) return;
    const auto count = static_cast<Catom>(subdomain.ensemble.index_count());
    subdomain.workers.run((count + kCatomsOfJob - 1) / kCatomsOfJob, [&](int worker, std::size_t job) {
        const auto first = static_cast<Catom>(job) * kCatomsOfJob;
        for (Catom c = first; c < std::min(count, first + kCatomsOfJob); ++c) {
            if (!subdomain.owned(c)) continue;
            if (const u64 news = sense_catom(subdomain, c, worker); news != 0) subdomain.mark_shared(c, news);
        }
    });
}

void RangeSenses::sense(Subdomain& subdomain, std::span<const Catom> catoms) const {
    for (const Catom catom : catoms)
        if (const u64 news = sense_catom(subdomain, catom, 0); news != 0) subdomain.mark(catom, news);
}

RangeSenses::Reading RangeSenses::measure(const Subdomain& subdomain, RangeQuantity quantity, Catom catom, Catom other) const {
    const world::Vec3 here = subdomain.ensemble.position(catom), there = subdomain.ensemble.position(other);
    const world::Vec3 way = {there[0] - here[0], there[1] - here[1], there[2] - here[2]};
    const std::uint64_t from = subdomain.ensemble.id(catom), to = subdomain.ensemble.id(other), seed = subdomain.world.seed;
    const double length = length_of(way);
    if (quantity == RangeQuantity::Distance) {
        const double noise = options_.distance_noise;
        const double wrong = noise > 0 ? noise * errors_between(seed, NoiseStream::Distances, from, to, way)[0] : 0;
        return {to, {std::max(0.0, length + wrong), 0, 0}};
    }
    // Of two nodes at the same place there is none.
    if (length == 0) return {to, {}};
    const world::Vec3 towards = {way[0] / length, way[1] / length, way[2] / length};
    const double noise = options_.bearing_noise_rad;
    if (noise == 0) return {to, towards};
    const auto [one, two] = errors_between(seed, NoiseStream::Bearings, from, to, way);
    return {to, turned(towards, noise * one, noise * two)};
}

u64 RangeSenses::sense_catom(Subdomain& subdomain, Catom catom, int worker) const {
    u64 news = 0;
    for (const Sensor& sensor : sensors_) {
        const bool vector = sensor.quantity == RangeQuantity::BearingVector;
        const std::size_t numbers = sensor.quantity == RangeQuantity::Distance ? 1 : 3;
        std::vector<Reading> last, now;
        tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), sensor.predicate, catom, [&](const Value* v) {
            Reading one{.other = v[0].catom};
            for (std::size_t i = 0; i < numbers; ++i) one.at[i] = vector ? tuple::item(v[1].list, i).real : v[1 + i].real;
            last.push_back(one);
        });
        subdomain.each_neighbour(catom, [&](Catom other) { now.push_back(measure(subdomain, sensor.quantity, catom, other)); });
        // Zero has one sign where facts are stored.
        for (Reading& one : now)
            for (double& x : one.at) x += 0.0;
        std::ranges::sort(last, {}, &Reading::other);
        std::ranges::sort(now, {}, &Reading::other);
        if (last == now) continue;
        const auto change = [&](const Reading& one, bool given) {
            std::array<Value, 4> arguments{};
            arguments[0].catom = one.other;
            for (std::size_t i = 0; i < numbers && !vector; ++i) arguments[1 + i].real = one.at[i];
            std::array<u64, 3> words{};
            for (std::size_t i = 0; i < 3; ++i) words[i] = std::bit_cast<u64>(one.at[i]);
            const List list{words.data(), 3, 0};
            if (vector) arguments[1].list = &list;
            if (given)
                subdomain.give_shared(sensor.predicate, catom, arguments.data(), worker);
            else
                subdomain.take_shared(sensor.predicate, catom, arguments.data(), worker);
        };
        for (const Reading& one : last)
            if (!std::ranges::binary_search(now, one)) change(one, false);
        for (const Reading& one : now)
            if (!std::ranges::binary_search(last, one)) change(one, true);
        news |= sensor.dirty;
    }
    return news;
}

}  // namespace meld::sim
