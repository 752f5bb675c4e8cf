#include "runtime/ask/facts/local_facts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <initializer_list>

#include "runtime/base/assert.h"
#include "runtime/engine/tuple/facts.h"

namespace meld::inspect {

LocalFacts::LocalFacts(sim::Subdomain& subdomain, Holders* holders) : subdomain_(subdomain), holders_(holders) { subdomain_.refresh(); }

const std::vector<std::pair<u64, sim::Catom>>& LocalFacts::by_id() {
    if (std::exchange(sorted_, true)) return by_id_;
    by_id_.reserve(subdomain_.ensemble.owned_count());
    for (sim::Catom c = 0; c < subdomain_.ensemble.index_count(); ++c)
        if (subdomain_.owned(c)) by_id_.emplace_back(subdomain_.ensemble.id(c), c);
    if (!std::ranges::is_sorted(by_id_)) std::ranges::sort(by_id_);
    return by_id_;
}

bool LocalFacts::exists(u64 catom) {
    const auto found = subdomain_.ensemble.find(catom);
    return found && subdomain_.owned(*found);
}

std::optional<Tombstone> LocalFacts::loss(const Source& source, u64 catom, u64 group) {
    const auto found = subdomain_.ensemble.find(catom);
    if (!found || !subdomain_.owned(*found) || source.predicate >= kNone16) return std::nullopt;
    const auto* const entry = subdomain_.tombstones().find(*found, static_cast<u16>(source.predicate), group);
    if (entry == nullptr) return std::nullopt;
    return Tombstone{.least_rank = entry->least_rank, .time = entry->time};
}

bool LocalFacts::at(const Source& source, u64 catom, const Visit& visit) {
    const auto found = subdomain_.ensemble.find(catom);
    if (!found || !subdomain_.owned(*found)) return true;
    if (visits_ == rooms_.size()) rooms_.emplace_back();
    const bool more = at(source, *found, catom, rooms_[visits_++], visit);
    --visits_;
    return more;
}

bool LocalFacts::travels(const Source& source) const {
    if (source.kind != Source::Kind::Stored || !subdomain_.world.apart() || !subdomain_.ensemble.keeps_links()) return false;
    const PredicateInfo& p = subdomain_.module.predicates[source.predicate];
    return p.column != kNone16 && p.storage != Storage::PerLink && subdomain_.module.columns[p.column].exported;
}

bool LocalFacts::heard(const Source& source, u64 catom, u64 by, const Visit& visit) {
    if (!travels(source)) return at(source, catom, visit);
    const auto reader = subdomain_.ensemble.find(by), other = subdomain_.ensemble.find(catom);
    if (!reader || !subdomain_.owned(*reader) || !other) return true;
    const world::Links& links = subdomain_.ensemble.links();
    const auto port = links.towards(*reader, *other);
    const std::int32_t index = port ? links.read(*reader, *port) : -1;
    if (index < 0) return true;
    if (visits_ == rooms_.size()) rooms_.emplace_back();
    const bool more = stored(source, static_cast<sim::Catom>(index), catom, rooms_[visits_++], visit);
    --visits_;
    return more;
}

bool LocalFacts::each(const Source& source, const Visit& visit) {
    std::vector<Value> room;
    const auto* const few = holders_ != nullptr && source.kind == Source::Kind::Stored ? holders_->few(source.predicate) : nullptr;
    for (const auto& [id, catom] : few != nullptr ? *few : by_id())
        if (!at(source, catom, id, room, visit)) return false;
    return true;
}

bool LocalFacts::at(const Source& source, sim::Catom catom, u64 id, std::vector<Value>& room, const Visit& visit) const {
    switch (source.kind) {
        case Source::Kind::Stored:
            return stored(source, catom, id, room, visit);
        case Source::Kind::World:
            return world(source, catom, id, visit);
        case Source::Kind::Actions:
            return actions(source, catom, id, visit);
        case Source::Kind::Nowhere:
            return true;
    }
    return true;
}

bool LocalFacts::stored(const Source& source, sim::Catom catom, u64 id, std::vector<Value>& room, const Visit& visit) const {
    Fact fact{.catom = id};
    const auto one = [&](const Value* arguments, u32 rank) {
        fact.arguments = arguments;
        fact.rank = rank;
        return visit(fact);
    };
    return tuple::each_ranked_fact(subdomain_.module, subdomain_.columns, subdomain_.geometry(), source.predicate, catom, room,
                                   std::ref(one));
}

bool LocalFacts::actions(const Source& source, sim::Catom catom, u64 id, const Visit& visit) const {
    const std::vector<eval::Action>& all = subdomain_.actions();
    const auto number = [&](const eval::Action& action) { return subdomain_.ensemble.id(action.catom); };
    for (auto at = std::ranges::lower_bound(all, id, {}, number); at != all.end() && at->catom == catom; ++at)
        if (at->predicate == source.predicate && !visit({.catom = id, .arguments = at->arguments})) return false;
    return true;
}

// As modules read them (compiler/emit/matches.cpp).
bool LocalFacts::world(const Source& source, sim::Catom catom, u64 id, const Visit& visit) const {
    const Geometry& g = subdomain_.geometry();
    const u32 site = g.catom_site[catom];
    const auto tell = [&](std::initializer_list<Value> arguments) { return visit({.catom = id, .arguments = arguments.begin()}); };
    const auto real = [](double v) { return Value{.real = v}; };
    // Calls tell_one(port, neighbour or -1) for each port.
    const auto each_port = [&](const auto& tell_one) {
        for (i32 port = 0; port < ports_of(g, catom); ++port)
            if (!tell_one(port, neighbour_at(g, catom, port))) return false;
        return true;
    };
    // The same of (port, the site behind it), of the ports of a lattice.
    const auto each_place = [&](const auto& tell_one) {
        for (i32 port = 0; port < places_of(g, catom); ++port)
            if (!tell_one(port, site_beside(g, catom, port))) return false;
        return true;
    };
    switch (source.world) {
        case WorldSource::Neighbor:
            return each_port([&](i32, i32 other) { return other < 0 || tell({{.catom = id_of(g, static_cast<u32>(other))}}); });
        case WorldSource::NeighborPort:
            return each_port(
                [&](i32 port, i32 other) { return other < 0 || tell({{.catom = id_of(g, static_cast<u32>(other))}, {.integer = port}}); });
        case WorldSource::NeighborCount: {
            i64 count = 0;
            each_port([&](i32, i32 other) { return count += other >= 0, true; });
            return tell({{.integer = count}});
        }
        case WorldSource::Vacant:
            return subdomain_.ensemble.is_free() ||
                   each_place([&](i32 port, u32 place) { return g.cell_catom[place] >= 0 || tell({{.integer = port}}); });
        case WorldSource::Target:
            return !in_target(g, site) || tell({});
        case WorldSource::TargetPort:
            return subdomain_.ensemble.is_free() ||
                   each_place([&](i32 port, u32 place) { return !in_target(g, place) || tell({{.integer = port}}); });
        case WorldSource::Expanded:
            return !is_expanded(g, catom) || tell({});
        case WorldSource::Head:
            return !is_expanded(g, catom) || tell({{.integer = head_direction(g, catom)}});
        case WorldSource::Tail:
            return !is_expanded(g, catom) || tell({{.integer = (head_direction(g, catom) + kDirections / 2) % kDirections}});
        case WorldSource::Port:
            return g.catom_tail == nullptr || each_place([&](i32 port, u32 place) {
                       const i32 at = g.cell_catom[place];
                       if (at < 0 || static_cast<u32>(at) == catom) return true;
                       const u32 other = static_cast<u32>(at);
                       return tell({{.integer = port},
                                    {.catom = id_of(g, other)},
                                    {.integer = port_back(g, catom, port, other)},
                                    {.integer = is_expanded(g, other) ? 2 : 1}});
                   });
        case WorldSource::Id:
            return tell({{.integer = static_cast<i64>(id)}});
        case WorldSource::Tick:
            return tell({{.integer = subdomain_.tick()}});
        case WorldSource::Cell:
            return subdomain_.ensemble.is_free() || tell({{.integer = cell_coordinate(g, site, 0)},
                                                          {.integer = cell_coordinate(g, site, 1)},
                                                          {.integer = cell_coordinate(g, site, 2)}});
        case WorldSource::Position:
        case WorldSource::PositionVector: {
            const world::Vec3 p = subdomain_.sensed_position(catom);
            if (source.world == WorldSource::Position) return tell({real(p[0]), real(p[1]), real(p[2])});
            const std::array words = {std::bit_cast<u64>(p[0]), std::bit_cast<u64>(p[1]), std::bit_cast<u64>(p[2])};
            const List list{words.data(), 3, 0};
            return tell({{.list = &list}});
        }
        case WorldSource::Facts:
        case WorldSource::None:
            break;
    }
    MELD_CHECK(false, "a question reads sense {}", static_cast<int>(source.world));
}

bool LocalFacts::back(const Source& source, u64 to, const Visit& visit) {
    MELD_EXPECT(is_link(source.world), "sense {} is followed back", static_cast<int>(source.world));
    const auto found = subdomain_.ensemble.find(to);
    if (!found || !subdomain_.owned(*found)) return true;
    const Geometry& g = subdomain_.geometry();
    for (i32 port = 0; port < ports_of(g, *found); ++port) {
        const i32 other = neighbour_at(g, *found, port);
        if (other < 0) continue;
        const std::array<Value, 2> arguments = {Value{.catom = to}, Value{.integer = port_there(g, *found, port)}};
        if (!visit({.catom = id_of(g, static_cast<u32>(other)), .arguments = arguments.data()})) return false;
    }
    return true;
}

}  // namespace meld::inspect
