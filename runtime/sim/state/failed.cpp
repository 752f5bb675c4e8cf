#include "runtime/sim/state/failed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "runtime/sim/state/reading.h"

namespace meld::sim {

using world::Port;

namespace {

// Two catoms, by their ids or cells.
using CatomPair = std::pair<std::uint64_t, std::uint64_t>;

void find_in_graph(const Subdomain& subdomain, Catom catom, std::vector<CatomPair>& missing, std::vector<JoinedNodes>& joined) {
    const Nodes& graph = subdomain.nodes();
    const world::Ensemble& ensemble = subdomain.ensemble;
    const graph::Node node = *graph.find(ensemble.id(catom));
    const auto row = graph.neighbours(node);
    for (Port port = 0; port < ensemble.links().ports(catom); ++port) {
        const std::optional<Catom> other = ensemble.links().at(catom, port);
        if (port < row.size()) {
            // Also a node that has been killed: it is not known here.
            if (!other && graph.id(row[port]) > ensemble.id(catom)) missing.emplace_back(ensemble.id(catom), graph.id(row[port]));
        } else if (other && ensemble.id(*other) > ensemble.id(catom)) {
            joined.push_back({node, *graph.find(ensemble.id(*other)), port, ensemble.links().port_there(catom, port)});
        }
    }
}

void find_on_lattice(const Subdomain& subdomain, Catom catom, std::vector<CatomPair>& missing) {
    const world::Ensemble& ensemble = subdomain.ensemble;
    // Links of amoebots are never cut.
    if (ensemble.has_amoebots()) return;
    for (int port = 0; port < subdomain.lattice.ports(); ++port) {
        if (ensemble.links().at(catom, static_cast<Port>(port))) continue;
        const std::optional<Catom> other = ensemble.at(subdomain.lattice.neighbour(ensemble.cell(catom), port));
        if (other && ensemble.id(*other) > ensemble.id(catom)) missing.emplace_back(ensemble.id(catom), ensemble.id(*other));
    }
}

}  // namespace

void Failed::save(const Subdomain& subdomain, ByteWriter& out) {
    const world::Ensemble& ensemble = subdomain.ensemble;
    std::vector<CatomPair> missing;
    std::vector<JoinedNodes> joined;
    const bool bodies = ensemble.is_free() && !ensemble.is_graph();
    for (Catom c = 0; ensemble.keeps_links() && !bodies && c < ensemble.index_count(); ++c) {
        if (!subdomain.owned(c)) continue;
        if (ensemble.is_graph())
            find_in_graph(subdomain, c, missing, joined);
        else
            find_on_lattice(subdomain, c, missing);
    }
    const auto write = [&](const auto& list) {
        out.write_count(list.size());
        for (const auto& item : list) out.write(item);
    };
    write(subdomain.status().hung);
    out.write_count(subdomain.status().dying.size());
    for (const Dying& one : subdomain.status().dying) {
        out.write(one.tick);
        out.write(one.id);
        out.write(one.cell);
    }
    out.write_count(missing.size());
    for (const auto& [a, b] : missing) out.write(a), out.write(b);
    write(joined);
    // The same on all processes.
    const bool tells = ensemble.is_graph() && subdomain.comm.process() == 0;
    out.write_count(tells ? subdomain.nodes().made().size() : 0);
    if (!tells) return;
    for (const Nodes::Made& one : subdomain.nodes().made()) out.write(one.id), out.write(one.maker);
    if (!subdomain.world.has_moving_nodes()) return;
    for (graph::Node node = 0; node < subdomain.nodes().count(); ++node) out.write(subdomain.nodes().place(node));
}

Result<void> Failed::read(const world::World& world, ByteReader& in) {
    hung_.resize(in.read_count(sizeof(std::uint64_t)));
    for (std::uint64_t& id : hung_) id = in.read<std::uint64_t>();
    if (!std::ranges::is_sorted(hung_, std::ranges::less_equal())) return damaged("has catoms that hang in no order");
    dying_.resize(in.read_count(sizeof(std::int64_t)));
    for (Dying& one : dying_) {
        one.tick = in.read<std::int64_t>();
        one.id = in.read<std::uint64_t>();
        one.cell = in.read<world::Cell>();
    }
    if (!std::ranges::is_sorted(dying_, {}, &Dying::tick)) return damaged("has catoms that die in no order");
    for (std::size_t left = in.read_count(sizeof(CatomPair)); left > 0; --left) {
        const auto a = in.read<std::uint64_t>();
        missing_.emplace_back(a, in.read<std::uint64_t>());
    }
    for (std::size_t left = in.read_count(sizeof(JoinedNodes)); left > 0; --left) {
        const auto link = in.read<JoinedNodes>();
        if (!world.is_graph()) return damaged("has links of nodes, and the world none");
        joined_.push_back(link);
    }
    for (std::size_t left = in.read_count(sizeof(std::uint64_t) + sizeof(graph::Node)); left > 0; --left) {
        const auto id = in.read<std::uint64_t>();
        const auto maker = in.read<graph::Node>();
        const std::uint64_t before = !world.is_graph() ? 0 : made_.empty() ? world.graph->next_id() : made_.back().id + 1;
        if (!world.is_graph() || id < before || maker >= world.graph->nodes() + made_.size())
            return damaged(fmt::format("has a node @{} that no rule can have made", id));
        made_.push_back({id, maker});
    }
    // Those of process 0, for all.
    while (world.has_moving_nodes() && !in.failed() && !in.done()) places_.push_back(in.read<graph::Point>());
    return in.failed() ? in.outcome() : Result<void>{};
}

Result<void> Failed::check_joined(const Nodes& nodes) const {
    for (const JoinedNodes& link : joined_) {
        // Ports beyond those of the graph are taken one after the other.
        const auto fits = [&](graph::Node node, Port port) {
            return node < nodes.count() && port >= nodes.neighbours(node).size() && port < nodes.neighbours(node).size() + nodes.count();
        };
        if (!fits(link.a, link.port_of_a) || !fits(link.b, link.port_of_b) || link.a == link.b)
            return damaged(fmt::format("has a link of nodes {} and {} that cannot be", link.a, link.b));
    }
    return {};
}

Result<void> Failed::place(Nodes& nodes) const {
    if (places_.size() != nodes.count()) return damaged(fmt::format("has {} places of {} nodes", places_.size(), nodes.count()));
    for (graph::Node node = 0; node < places_.size(); ++node) {
        if (!std::ranges::all_of(places_[node], [](double x) { return std::isfinite(x); }))
            return damaged(fmt::format("has a place of node {} that is not finite", node));
        nodes.move(node, places_[node]);
    }
    return {};
}

void Failed::cut(world::Ensemble& ensemble) const {
    if (!ensemble.keeps_links()) return;
    for (const auto& [a, b] : missing_) {
        const std::optional<Catom> here = ensemble.find(a), there = ensemble.find(b);
        const std::optional<Port> port = here && there ? ensemble.links().towards(*here, *there) : std::nullopt;
        if (port) ensemble.links().disconnect(*here, *port);
    }
}

}  // namespace meld::sim
