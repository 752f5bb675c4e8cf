#include "runtime/sim/network/fates.h"

#include <algorithm>
#include <array>

namespace meld::sim {

const world::LinkTerms& Fates::terms(u32 part) const {
    const world::NetworkOptions& network = world_.network;
    if (part == 0) return network.terms;
    return part <= network.parts.size() ? network.parts[part - 1].terms : network.singles[part - 1 - network.parts.size()].terms;
}

u32 Fates::part_between(Catom from, Catom to) const {
    const world::NetworkOptions& network = world_.network;
    if (const auto single = network.single(members_.ensemble.id(from), members_.ensemble.id(to)))
        return static_cast<u32>(network.parts.size()) + *single + 1;
    u32 last = 0;
    for (u32 part = 0; part < network.parts.size(); ++part) {
        const world::Region& where = network.parts[part].where;
        if (members_.in_region(where, from) || members_.in_region(where, to)) last = part + 1;
    }
    return last;
}

world::Fate Fates::of(u32 part, Catom from, Catom to, i64 now) const {
    return world::fate(world_.network.kind, terms(part), world_.seed, members_.ensemble.id(from), members_.ensemble.id(to), now);
}

void Fates::of(Catom from, std::span<const Reader> to, i64 now, std::span<world::Fate> fates) const {
    const world::NetworkOptions& network = world_.network;
    if (!same_terms()) {
        for (std::size_t i = 0; i < to.size(); ++i) fates[i] = of(part_between(from, to[i].catom), from, to[i].catom, now);
        return;
    }
    std::array<u64, kReadersAtOnce> ids;
    for (std::size_t i = 0; i < to.size(); ++i) ids[i] = members_.ensemble.id(to[i].catom);
    world::fates(network.kind, network.terms, world_.seed, members_.ensemble.id(from), {ids.data(), to.size()}, now, fates);
}

void Fates::delays(Catom from, std::span<const Reader> to, i64 now, std::span<u32> ticks) const {
    std::array<u64, kReadersAtOnce> ids;
    for (std::size_t i = 0; i < to.size(); ++i) ids[i] = members_.ensemble.id(to[i].catom);
    world::delays(world_.network.terms, world_.seed, members_.ensemble.id(from), {ids.data(), to.size()}, now, ticks);
}

i64 Fates::find_turn(Catom catom, i64 tick) {
    const i64 turn = world_.clock.next(world_.seed, members_.ensemble.id(catom), tick);
    if (catom >= turns_.size()) turns_.resize(members_.ensemble.index_count());
    turns_[catom] = {static_cast<u32>(tick), static_cast<u32>(turn - tick)};
    return turn;
}

i64 Fates::end_of_jam(i64 now, Catom from, Catom to) const {
    const world::Ensemble& ensemble = members_.ensemble;
    i64 until = now;
    for (const world::Event& event : world_.events) {
        if (event.jam.empty()) continue;
        const i64 begun = event.latest(now);
        for (const world::Jam& jam : event.jam)
            if (begun > 0 && begun + jam.ticks > until &&
                jam.links.contains(ensemble.id(from), ensemble.id(to),
                                   [&](const world::Region& region, int end) { return members_.in_region(region, end == 0 ? from : to); }))
                until = begun + jam.ticks;
    }
    return until;
}

void Fates::lose(i64 tick, Catom from, Catom to) {
    if (world_.network.kind == world::NetworkKind::Lossy) down_.push_back({tick, members_.ensemble.id(from), members_.ensemble.id(to)});
}

void Fates::note_loss(i64 now, Catom from, Catom to) {
    if (world_.network.kind != world::NetworkKind::Lossy || members_.ensemble.state(from) != kCatomOwned) return;
    const world::Fate fate = of(part_between(from, to), from, to, now);
    if (!fate.arrives) lose(now + fate.ticks, from, to);
}

void Fates::take_down(i64 now, const std::function<void(Catom)>& mark) {
    world::Ensemble& ensemble = members_.ensemble;
    const auto due = std::ranges::stable_partition(down_, [&](const Down& d) { return d.tick > now; });
    for (const Down& d : due) {
        const std::optional<Catom> from = ensemble.find(d.from), to = ensemble.find(d.to);
        const std::optional<world::Port> port = from && to ? ensemble.links().towards(*from, *to) : std::nullopt;
        if (!port) continue;
        ensemble.links().disconnect(*from, *port);
        mark(*from), mark(*to);
    }
    down_.erase(due.begin(), due.end());
}

void Fates::forget_loss(u64 a, u64 b) {
    std::erase_if(down_, [&](const Down& d) { return (d.from == a && d.to == b) || (d.from == b && d.to == a); });
}

void Fates::save(ByteWriter& out) const {
    out.write_count(down_.size());
    for (const Down& d : down_) out.write(d);
}

void Fates::load(ByteReader& in) {
    for (std::size_t left = in.read_count(sizeof(Down)); left > 0 && !in.failed(); --left) down_.push_back(in.read<Down>());
}

}  // namespace meld::sim
