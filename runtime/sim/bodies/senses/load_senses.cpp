#include "runtime/sim/bodies/senses/load_senses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/bodies/senses/body_senses.h"

namespace meld::sim {

namespace {

// Catoms that a worker takes at once: whole groups of the agenda.
constexpr Catom kLoadsOfJob = 1024;
// Smaller changes, as a share of the greatest load of all, are rounding.
constexpr double kRounding = 1e-6;

// As stored(), of a quantity. `broke` names a catom, which a predicate of the program's own need not do.
std::optional<u32> stored_of(const Subdomain& subdomain, BodyQuantity quantity, PredicateKind kind) {
    const auto sense = std::ranges::find(body_senses(), quantity, &BodySense::quantity);
    MELD_CHECK(sense != body_senses().end(), "the table has no such sense");
    const std::optional<u32> base = stored(subdomain, *sense, kind);
    return base && subdomain.module.predicates[*base].fields[0].type == ValueType::Node ? base : std::nullopt;
}

}  // namespace

void LoadSenses::start(const Subdomain& subdomain, const world::World& world) {
    load_ = stored_of(subdomain, BodyQuantity::Load, PredicateKind::Sensed);
    broke_ = stored_of(subdomain, BodyQuantity::Broke, PredicateKind::Linear);
    threshold_ = world.physics.sense.load;
}

void LoadSenses::note_broken(Subdomain& subdomain, std::span<const physics::ConnectionPair> broken) const {
    if (!broke_ || broken.empty()) return;
    for (const auto& [one, other] : broken)
        for (const auto& [at, to] : {std::pair{one, other}, std::pair{other, one}}) {
            const std::optional<Catom> catom = subdomain.ensemble.find(at);
            // Of several processes, all hear of all.
            if (!catom || !subdomain.owned(*catom)) continue;
            Value value{};
            value.catom = to;
            subdomain.give(*broke_, *catom, &value);
        }
    subdomain.note_change();
}

void LoadSenses::sense(Subdomain& subdomain, const physics::Scene& scene) const {
    if (!load_) return;
    Least least;
    for (const physics::Joint& each : scene.joints()) {
        least.force_n = std::max(least.force_n, each.load.force_n());
        least.torque_nm = std::max(least.torque_nm, each.load.torque_nm);
    }
    for (const physics::CarriedLoad& each : scene.loads()) {
        least.force_n = std::max(least.force_n, std::hypot(each.load.tension_n, each.load.shear_n));
        least.torque_nm = std::max(least.torque_nm, each.load.torque_nm());
    }
    if (!subdomain.alone()) {
        ByteWriter mine;
        mine.write(least);
        for (const auto& from : gather_bytes(subdomain, mine)) {
            ByteReader in(from, "greatest loads");
            const auto theirs = in.read<Least>();
            least = {std::max(least.force_n, theirs.force_n), std::max(least.torque_nm, theirs.torque_nm)};
        }
    }
    least.force_n *= kRounding, least.torque_nm *= kRounding;
    const u64 dirty = subdomain.module.columns[subdomain.module.predicates[*load_].column].own_dirty;
    const auto count = static_cast<Catom>(subdomain.ensemble.index_count());
    subdomain.workers.run((count + kLoadsOfJob - 1) / kLoadsOfJob, [&](int worker, std::size_t job) {
        const auto first = static_cast<Catom>(job) * kLoadsOfJob;
        for (Catom c = first; c < std::min(count, first + kLoadsOfJob); ++c)
            if (subdomain.owned(c) && sense_catom(subdomain, scene, c, least, worker)) subdomain.mark_shared(c, dirty);
    });
}

void LoadSenses::lose(Subdomain& subdomain, const physics::Scene& scene, std::span<const physics::BodyId> lost) const {
    if (!load_) return;
    for (const physics::BodyId id : lost) {
        if (!scene.has(id)) continue;
        const auto forget = [&](physics::BodyId other) {
            const std::optional<Catom> catom = subdomain.ensemble.find(other);
            if (!catom || !subdomain.owned(*catom)) return;
            for (const Reading& each : sensed(subdomain, *catom))
                if (each.other == id) subdomain.take(*load_, *catom, arguments_of(each).data());
        };
        std::ranges::for_each(scene.connected_to(id), forget);
        std::ranges::for_each(scene.joined_to(id), forget);
    }
}

std::vector<LoadSenses::Reading> LoadSenses::sensed(const Subdomain& subdomain, Catom catom) const {
    std::vector<Reading> found;
    tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), *load_, catom, [&](const Value* v) {
        found.push_back({.other = v[0].catom, .tension_n = v[1].real, .shear_n = v[2].real, .torque_nm = v[3].real});
    });
    return found;
}

std::array<Value, 4> LoadSenses::arguments_of(const Reading& reading) {
    std::array<Value, 4> arguments{};
    arguments[0].catom = reading.other;
    arguments[1].real = reading.tension_n, arguments[2].real = reading.shear_n, arguments[3].real = reading.torque_nm;
    return arguments;
}

bool LoadSenses::differs(const Reading& last, const Reading& now, const Least& least) const {
    const double force = std::hypot(now.tension_n - last.tension_n, now.shear_n - last.shear_n);
    if (force > threshold_ * std::hypot(last.tension_n, last.shear_n) + least.force_n) return true;
    return std::abs(now.torque_nm - last.torque_nm) > threshold_ * last.torque_nm + least.torque_nm;
}

void LoadSenses::change(Subdomain& subdomain, u32 predicate, Catom catom, const Reading& reading, bool holds, int worker) {
    const std::array<Value, 4> arguments = arguments_of(reading);
    if (holds)
        subdomain.give_shared(predicate, catom, arguments.data(), worker);
    else
        subdomain.take_shared(predicate, catom, arguments.data(), worker);
}

bool LoadSenses::sense_catom(Subdomain& subdomain, const physics::Scene& scene, Catom catom, const Least& least, int worker) const {
    const std::vector<Reading> last = sensed(subdomain, catom);
    std::vector<Reading> now;
    const auto body = static_cast<physics::BodyId>(subdomain.ensemble.id(catom));
    const auto note = [&](physics::BodyId other, double tension_n, double shear_n, double torque_nm) {
        // Zero has one sign where facts are stored.
        const Reading found{.other = other, .tension_n = tension_n + 0.0, .shear_n = shear_n + 0.0, .torque_nm = torque_nm + 0.0};
        const auto former = std::ranges::find(last, found.other, &Reading::other);
        now.push_back(former == last.end() || differs(*former, found, least) ? found : *former);
    };
    for (const physics::BodyId other : scene.connected_to(body))
        if (const auto load = scene.load(body, other)) note(other, load->tension_n, load->shear_n, load->torque_nm());
    // What is connected, too, carries all by its connection.
    for (const physics::BodyId other : scene.joined_to(body))
        if (const auto load = scene.joint_load(body, other); load && !scene.connected(body, other))
            note(other, load->tension_n, load->shear_n, load->torque_nm);
    bool changed = false;
    const auto change_those_not_in = [&](const std::vector<Reading>& these, const std::vector<Reading>& others, bool holds) {
        for (const Reading& each : these) {
            if (std::ranges::find(others, each) != others.end()) continue;
            change(subdomain, *load_, catom, each, holds, worker);
            changed = true;
        }
    };
    change_those_not_in(last, now, false);
    change_those_not_in(now, last, true);
    return changed;
}

}  // namespace meld::sim
