#include "runtime/sim/core/failures/link_failures.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"

namespace meld::sim {

using world::LinkChoice;
using world::Port;

namespace {

bool contains(const LinkChoice& choice, const LinkFailures::End& a, const LinkFailures::End& b) {
    return choice.contains(a.id, b.id, [&](const world::Region& region, int end) {
        const LinkFailures::End& one = end == 0 ? a : b;
        return region.contains(one.id, one.cell, one.position);
    });
}

}  // namespace

LinkFailures::End LinkFailures::end_of(Catom catom) const {
    const Membership& m = subdomain_.members_;
    return {m.ensemble.id(catom), m.cell_in_regions(catom), m.ensemble.position(catom)};
}

LinkFailures::End LinkFailures::end_of_node(graph::Node node) const {
    const world::Vec3& at = subdomain_.nodes().place(node);
    return {subdomain_.nodes().id(node), nearest_cell(at), at};
}

void LinkFailures::strike() {
    const std::int64_t now = subdomain_.tick();
    const world::World& world = subdomain_.world;
    const auto by_events = [&](std::vector<LinkChoice> world::Event::* what) -> std::optional<Which> {
        std::vector<const LinkChoice*> regions;
        std::vector<Pair> pairs;
        for (const world::Event& event : world.events) {
            if (!event.happens_in(now)) continue;
            for (const LinkChoice& choice : event.*what) {
                if (choice.pair)
                    pairs.emplace_back(std::minmax(choice.pair->first, choice.pair->second));
                else
                    regions.push_back(&choice);
            }
        }
        if (regions.empty() && pairs.empty()) return std::nullopt;
        std::ranges::sort(pairs);
        return [regions, pairs](const End& a, const End& b) {
            return std::ranges::binary_search(pairs, Pair(std::minmax(a.id, b.id))) ||
                   std::ranges::any_of(regions, [&](const LinkChoice* choice) { return contains(*choice, a, b); });
        };
    };
    const auto by_chance = [&](world::Fault fault, double world::Faults::* probability) -> std::optional<Which> {
        const auto strikes = [now, probability](const world::Faults& one) { return one.*probability > 0 && one.strikes_in(now); };
        if (std::ranges::none_of(world.faults, strikes)) return std::nullopt;
        return [&world, now, fault, probability, strikes](const End& a, const End& b) {
            for (std::size_t i = 0; i < world.faults.size(); ++i) {
                const world::Faults& one = world.faults[i];
                if (strikes(one) && world::strikes(fault, one.*probability, world.seed, i, a.id, b.id, now) &&
                    contains({.where = one.where}, a, b))
                    return true;
            }
            return false;
        };
    };
    if (const auto which = by_events(&world::Event::cut)) cut(*which);
    if (const auto which = by_chance(world::Fault::Cut, &world::Faults::cut)) cut(*which);
    if (const auto which = by_events(&world::Event::heal)) heal(*which);
    if (const auto which = by_chance(world::Fault::Heal, &world::Faults::heal)) heal(*which);
    std::vector<Pair> joins;
    for (const world::Event& event : world.events)
        if (event.happens_in(now))
            for (const LinkChoice& choice : event.join) joins.push_back(*choice.pair);
    if (!joins.empty()) join(joins);
}

// The process of the end with the lower number counts it. What was lost before does not take another link down.
void LinkFailures::note(Catom a, Catom b, std::uint64_t& count) {
    const Catom lower = subdomain_.ensemble.id(a) < subdomain_.ensemble.id(b) ? a : b;
    count += subdomain_.owned(lower) ? 1 : 0;
    if (subdomain_.network_) subdomain_.network_->forget_loss(subdomain_.ensemble.id(a), subdomain_.ensemble.id(b));
    for (const Catom end : {a, b})
        if (subdomain_.owned(end)) subdomain_.mark(end, kDirtyLinks);
}

void LinkFailures::cut(const Which& which) {
    subdomain_.note_change();
    world::Ensemble& ensemble = subdomain_.members_.ensemble;
    std::vector<std::pair<Port, Catom>> gone;
    for (Catom c = 0; c < ensemble.index_count(); ++c) {
        if (ensemble.state(c) != kCatomOwned && ensemble.state(c) != kCatomGhost) continue;
        const End here = end_of(c);
        gone.clear();
        ensemble.links().each(c, [&](Port port, Catom other) {
            if (c < other && which(here, end_of(other))) gone.emplace_back(port, other);
        });
        for (const auto& [port, other] : gone) {
            ensemble.links().disconnect(c, port);
            note(c, other, subdomain_.status_.links_cut);
        }
    }
    subdomain_.refresh();
}

void LinkFailures::cut(std::span<const std::pair<Catom, Port>> links) {
    subdomain_.note_change();
    world::Links& all = subdomain_.members_.ensemble.links();
    for (const auto& [catom, port] : links) {
        const Catom other = *all.at(catom, port);
        all.disconnect(catom, port);
        note(catom, other, subdomain_.status_.links_cut);
    }
    subdomain_.refresh();
}

void LinkFailures::heal(const Which& which) {
    subdomain_.note_change();
    if (subdomain_.ensemble.is_graph())
        connect(missing_in_graph(which));
    else
        heal_cells(which);
    subdomain_.refresh();
}

void LinkFailures::heal_cells(const Which& which) {
    world::Ensemble& ensemble = subdomain_.members_.ensemble;
    const world::Lattice& lattice = subdomain_.lattice;
    for (Catom c = 0; c < ensemble.index_count(); ++c) {
        if (ensemble.state(c) != kCatomOwned && ensemble.state(c) != kCatomGhost) continue;
        for (int port = 0; port < lattice.ports(); ++port) {
            if (ensemble.links().at(c, static_cast<Port>(port))) continue;
            const std::optional<Catom> other = ensemble.at(lattice.neighbour(ensemble.cell(c), port));
            if (!other || *other < c || !which(end_of(c), end_of(*other))) continue;
            ensemble.links().connect(c, static_cast<Port>(port), *other, static_cast<Port>(lattice.opposite(port)));
            note(c, *other, subdomain_.status_.links_made);
        }
    }
}

// Their other ends may be gone.
std::vector<LinkFailures::Pair> LinkFailures::missing_in_graph(const Which& which) const {
    const Nodes& graph = subdomain_.nodes();
    const world::Ensemble& ensemble = subdomain_.ensemble;
    std::vector<Pair> missing;
    for (Catom c = 0; c < ensemble.index_count(); ++c) {
        if (!subdomain_.owned(c)) continue;
        const graph::Node node = *graph.find(ensemble.id(c));
        Port port = 0;
        for (const graph::Node other : graph.neighbours(node))
            if (!ensemble.links().at(c, port++) && which(end_of(c), end_of_node(other)))
                missing.emplace_back(ensemble.id(c), graph.id(other));
    }
    return missing;
}

void LinkFailures::join(const std::vector<Pair>& pairs) {
    subdomain_.note_change();
    std::vector<Pair> wanted;
    for (const auto& [a, b] : pairs)
        for (const auto& [mine, other] : {Pair(a, b), Pair(b, a)}) {
            const std::optional<Catom> here = subdomain_.ensemble.find(mine), there = subdomain_.ensemble.find(other);
            if (here && subdomain_.owned(*here) && !(there && subdomain_.ensemble.links().towards(*here, *there)))
                wanted.emplace_back(mine, other);
        }
    connect(std::move(wanted));
    subdomain_.refresh();
}

void LinkFailures::connect(std::vector<Pair> wanted) {
    const Nodes& graph = subdomain_.nodes();
    Membership& m = subdomain_.members_;
    // By all ends.
    std::set<Pair> all(wanted.begin(), wanted.end());
    if (!subdomain_.alone()) {
        ByteWriter mine;
        for (const auto& [a, b] : wanted) mine.write(a), mine.write(b);
        for (const auto& theirs : subdomain_.comm.allgather_any(mine.view()))
            for (ByteReader in(theirs, "links that are made"); !in.done();) {
                const auto a = in.read<std::uint64_t>();
                all.emplace(a, in.read<std::uint64_t>());
            }
    }
    std::erase_if(all, [&](const Pair& link) { return !all.contains({link.second, link.first}); });
    // A link of the graph has its port; others have those after them, in the order of the pairs.
    std::map<Pair, Port> ports;
    std::map<std::uint64_t, std::set<Port>> taken;
    for (const auto& [a, b] : all) {
        const std::optional<Catom> catom = m.ensemble.find(a);
        if (!catom || !subdomain_.owned(*catom)) continue;
        const graph::Node node = *graph.find(a);
        const auto row = graph.neighbours(node);
        const auto at = std::ranges::lower_bound(row, *graph.find(b));
        auto port = static_cast<Port>(at - row.begin());
        if (at == row.end() || *at != *graph.find(b)) {
            port = static_cast<Port>(row.size());
            const auto used = [&] {
                return (port < m.ensemble.links().ports(*catom) && m.ensemble.links().at(*catom, port)) || taken[a].contains(port);
            };
            while (used()) ++port;
            taken[a].insert(port);
        }
        ports[{a, b}] = port;
    }
    if (!subdomain_.alone()) {
        ByteWriter mine;
        for (const auto& [link, port] : ports) {
            const std::optional<Catom> other = m.ensemble.find(link.second);
            if (other && subdomain_.owned(*other)) continue;
            mine.write(link.first), mine.write(link.second), mine.write(port);
            const std::size_t exports = mine.begin_block();
            subdomain_.pack_catom(*m.ensemble.find(link.first), kCatomGhost, mine);
            mine.end_block(exports);
        }
        const auto theirs = subdomain_.comm.allgather_any(mine.view());
        for (std::size_t process = 0; process < theirs.size(); ++process)
            for (ByteReader in(theirs[process], "the ends of links that are made"); !in.done();) {
                const auto a = in.read<std::uint64_t>(), b = in.read<std::uint64_t>();
                const auto port = in.read<Port>();
                ByteReader exports(in.read_block(), "what an end of a link exports");
                if (!ports.contains({b, a}) || static_cast<int>(process) == subdomain_.comm.process()) continue;
                ports[{a, b}] = port;
                std::optional<Catom> ghost = m.ensemble.find(a);
                // One that is linked here is as its owner left it. If it were unpacked again, its neighbours would read all of it once
                // more, which takes derivations that a run on one process does not.
                bool known = false;
                if (ghost) subdomain_.each_neighbour(*ghost, [&](Catom) { known = true; });
                if (known) continue;
                if (!ghost) ghost = subdomain_.add_freely(a, end_of_node(*graph.find(a)).position, kCatomGhost, static_cast<int>(process));
                subdomain_.facts_.columns.clear(*ghost, 0);
                subdomain_.unpack_catom(*ghost, exports);
            }
    }
    for (const auto& [link, port] : ports) {
        if (link.first > link.second) continue;
        const Catom a = *m.ensemble.find(link.first), b = *m.ensemble.find(link.second);
        const Port there = ports.at({link.second, link.first});
        m.ensemble.links().room(a, port + 1);
        m.ensemble.links().room(b, there + 1);
        m.ensemble.links().connect(a, port, b, there);
        note(a, b, subdomain_.status_.links_made);
    }
}

}  // namespace meld::sim
