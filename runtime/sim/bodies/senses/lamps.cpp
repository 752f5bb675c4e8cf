#include "runtime/sim/bodies/senses/lamps.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/core/setup/unmatched.h"

namespace meld::sim {

void Lamps::find(Subdomain& subdomain) {
    const std::vector<world::LampOptions>& lamps = world_.physics.lamps;
    ByteWriter mine;
    Unmatched unmatched(subdomain.comm);
    for (std::uint32_t i = 0; i < lamps.size(); ++i) {
        if (!is_carried(i)) continue;
        bool met = false;
        for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
            if (!subdomain.owned(c)) continue;
            const std::uint64_t id = subdomain.ensemble.id(c);
            if (!lamps[i].where.contains(id, subdomain.start_cell(c), subdomain.ensemble.position(c))) continue;
            mine.write(Carried{static_cast<physics::BodyId>(id), i, lamps[i].share});
            met = true;
        }
        unmatched.add(met, [&lamp = lamps[i]] {
            return fmt::format("{}: `{}` matches no catom, so this [[motion.lamp]] shines nowhere", lamp.place, lamp.where.text());
        });
    }
    unmatched.warn();
    carried_.clear();
    if (std::ranges::none_of(lamps, [](const world::LampOptions& lamp) { return !lamp.position; })) return;
    for (const auto& from : gather_bytes(subdomain, mine))
        for (ByteReader in(from, "catoms with lamps"); !in.done();) carried_.push_back(in.read<Carried>());
    std::ranges::sort(carried_, std::less<>());
}

std::vector<Catom> Lamps::carry_out(Subdomain& subdomain, std::span<const AskedLamp> asked) {
    std::vector<Catom> refused;
    std::map<physics::BodyId, double> shares;
    const auto carries = [&](physics::BodyId body) { return std::ranges::binary_search(carried_, body, {}, &Carried::body); };
    for (const AskedLamp& ask : asked) {
        const auto body = static_cast<physics::BodyId>(subdomain.ensemble.id(ask.catom));
        if (!carries(body)) {
            refused.push_back(ask.catom);
            continue;
        }
        // What is not a number counts as 0, too.
        const double share = ask.share > 0 ? std::min(ask.share, 1.0) : 0;
        double& brightest = shares.try_emplace(body, share).first->second;
        brightest = std::max(brightest, share);
    }
    ByteWriter mine;
    for (const auto& [body, share] : shares) mine.write(body), mine.write(share);
    for (const auto& from : gather_bytes(subdomain, mine))
        for (ByteReader in(from, "lamps that are dimmed"); !in.done();) {
            const auto body = in.read<physics::BodyId>();
            const auto share = in.read<double>();
            for (Carried& lamp : std::ranges::equal_range(carried_, body, {}, &Carried::body)) lamp.share = share;
        }
    return refused;
}

void Lamps::lose(std::span<const physics::BodyId> lost) {
    std::erase_if(carried_, [&](const Carried& lamp) { return std::ranges::binary_search(lost, lamp.body); });
}

Shining Lamps::shining_at(physics::Vec3 place_m, std::size_t lamp, double share) const {
    const world::LampOptions& options = world_.physics.lamps[lamp];
    const double reach_m = options.reach ? *options.reach * 2 * world_.radius : std::numeric_limits<double>::infinity();
    return {place_m, share * options.power, reach_m, std::nullopt};
}

void Lamps::place(Subdomain& subdomain, const physics::Scene& scene) {
    shining_.clear();
    const std::vector<world::LampOptions>& lamps = world_.physics.lamps;
    for (std::size_t i = 0; i < lamps.size(); ++i)
        if (!is_carried(i) && lamps[i].share > 0) shining_.push_back(shining_at(to_metres(world_, *lamps[i].position), i, lamps[i].share));
    if (carried_.empty()) return;
    ByteWriter mine;
    for (std::size_t i = 0; i < carried_.size(); ++i) {
        if (!(carried_[i].share > 0)) continue;
        const std::optional<Catom> catom = subdomain.ensemble.find(carried_[i].body);
        if (!catom || !subdomain.owned(*catom)) continue;
        mine.write(i);
        mine.write(scene.state(carried_[i].body).position_m);
    }
    std::map<std::size_t, physics::Vec3> places;
    for (const auto& from : gather_bytes(subdomain, mine))
        for (ByteReader in(from, "places of lamps"); !in.done();) {
            const auto i = in.read<std::size_t>();
            places[i] = in.read<physics::Vec3>();
        }
    for (const auto& [i, place_m] : places) {
        shining_.push_back(shining_at(place_m, carried_[i].lamp, carried_[i].share));
        shining_.back().body = carried_[i].body;
    }
}

void Lamps::save(ByteWriter& out) const {
    out.write_count(carried_.size());
    for (const Carried& lamp : carried_) out.write(lamp);
}

void Lamps::load(ByteReader& in) {
    // Each process has saved all of them.
    carried_.clear();
    for (auto left = in.read_count(sizeof(Carried)); left > 0; --left)
        if (const auto lamp = in.read<Carried>(); lamp.lamp < world_.physics.lamps.size()) carried_.push_back(lamp);
}

}  // namespace meld::sim
