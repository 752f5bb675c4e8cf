#include "runtime/sim/bodies/senses/sensor_facts.h"

#include <algorithm>
#include <array>

#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/bodies/senses/body_senses.h"

namespace meld::sim {

namespace {

// Catoms that a worker takes at once: whole groups of the agenda.
constexpr Catom kCatomsOfSensorJob = 256;

}  // namespace

void SensorFacts::start(const Subdomain& subdomain, BodyQuantity quantity) {
    for (const BodySense& sense : body_senses())
        if (sense.quantity == quantity) predicate_ = stored(subdomain, sense);
    if (predicate_) dirty_ = subdomain.module.columns[subdomain.module.predicates[*predicate_].column].own_dirty;
}

void SensorFacts::sense(Subdomain& subdomain, std::size_t sensors, const Measure& measure, const Differs& differs) const {
    const auto count = static_cast<Catom>(subdomain.ensemble.index_count());
    subdomain.workers.run((count + kCatomsOfSensorJob - 1) / kCatomsOfSensorJob, [&](int worker, std::size_t job) {
        const auto first = static_cast<Catom>(job) * kCatomsOfSensorJob;
        for (Catom c = first; c < std::min(count, first + kCatomsOfSensorJob); ++c)
            if (subdomain.owned(c) && sense_catom(subdomain, sensors, measure, differs, c, worker)) subdomain.mark_shared(c, dirty_);
    });
}

bool SensorFacts::sense_catom(Subdomain& subdomain, std::size_t sensors, const Measure& measure, const Differs& differs, Catom catom,
                              int worker) const {
    std::vector<std::optional<double>> last(sensors);
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), *predicate_, catom, [&](const Value* v) {
        const auto sensor = static_cast<std::size_t>(v[0].integer);
        if (sensor < last.size()) last[sensor] = v[1].real;
    });
    bool news = false;
    for (std::size_t i = 0; i < sensors; ++i) {
        const std::optional<double> now = measure(catom, i);
        if (now && last[i] && !differs(*last[i], *now)) continue;
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
