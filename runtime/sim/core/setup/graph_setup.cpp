// Catoms that are the nodes of a graph: who owns which, ghosts of the neighbours elsewhere, and the table of links.
#include "runtime/sim/core/setup/graph_setup.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/world/graph/divide.h"

namespace meld::sim {

using graph::Graph;
using graph::Node;

namespace {

constexpr std::int32_t kUnknown = -1;

const world::Vec3& place_of(const Nodes& all, Node node) { return all.place(node); }

// Nodes are linked in ascending order, so a port is the place in the row of neighbours, on every process.
world::Port port_towards(const Nodes& all, Node node, Node other) {
    const auto row = all.neighbours(node);
    return static_cast<world::Port>(std::lower_bound(row.begin(), row.end(), other) - row.begin());
}

// By node. Dividing takes long and much memory, so one process does it.
std::vector<std::int32_t> owners(const Graph& graph, comm::Communicator& comm) {
    if (comm.processes() == 1) return graph::divide(graph, 1);
    std::vector<std::int32_t> mine;
    if (comm.process() == 0) mine = graph::divide(graph, comm.processes());
    const std::vector<std::byte> first = std::move(comm.allgather_any(std::as_bytes(std::span(mine))).front());
    MELD_CHECK(first.size() == graph.nodes() * sizeof(std::int32_t), "{} bytes for {} nodes", first.size(), graph.nodes());
    mine.resize(graph.nodes());
    if (!first.empty()) std::memcpy(mine.data(), first.data(), first.size());
    return mine;
}

}  // namespace

std::vector<JoinedNodes> first_links(const Graph& graph) {
    std::vector<JoinedNodes> links;
    links.reserve(graph.links());
    // Rows are ascending, so the entries of each row are met in order when those of lower nodes are visited in order.
    std::vector<world::Port> next(graph.nodes());
    for (Node node = 0; node < graph.nodes(); ++node) {
        world::Port port = 0;
        for (const Node other : graph.neighbours(node)) {
            if (node < other) links.push_back({node, other, port, next[other]++});
            ++port;
        }
    }
    return links;
}

void populate_graph(Membership& members, const Graph& graph, comm::Communicator& comm, const std::vector<bool>* left,
                    std::span<const JoinedNodes> joined) {
    const int process = comm.process();
    const Nodes& all = *members.nodes;
    std::vector<std::int32_t> owner = owners(graph, comm);
    for (const Nodes::Made& made : all.made()) owner.push_back(Nodes::owner(made.id, comm.processes()));
    const auto nodes = static_cast<Node>(all.count());
    const auto there = [&](Node node) { return left == nullptr || (*left)[node]; };
    members.next_id = graph.next_id();
    std::vector<std::int32_t> catom_of(nodes, kUnknown);
    std::vector<Node> mine, ghosts;
    std::size_t ports = 0;
    for (Node node = 0; node < nodes; ++node) {
        if (owner[node] != process || !there(node)) continue;
        mine.push_back(node);
        ports += all.neighbours(node).size();
        for (const Node other : all.neighbours(node))
            if (owner[other] != process && there(other) && std::exchange(catom_of[other], 0) == kUnknown) {
                ghosts.push_back(other);
                ports += all.neighbours(other).size();
            }
    }
    for (const JoinedNodes& link : joined)
        for (const auto& [node, other] : {std::pair(link.a, link.b), std::pair(link.b, link.a)})
            if (owner[node] == process && there(node) && owner[other] != process && there(other) &&
                std::exchange(catom_of[other], 0) == kUnknown)
                ghosts.push_back(other);
    std::sort(ghosts.begin(), ghosts.end());
    members.reserve_nodes(mine.size() + ghosts.size(), ports);
    const auto add = [&](Node node) {
        const Catom catom =
            members.add_freely(all.id(node), place_of(all, node), owner[node] == process ? kCatomOwned : kCatomGhost, owner[node]);
        members.ensemble.links().room(catom, static_cast<world::Port>(all.neighbours(node).size()));
        catom_of[node] = static_cast<std::int32_t>(catom);
    };
    std::ranges::for_each(mine, add);
    std::ranges::for_each(ghosts, add);
    for (const Node node : mine) {
        world::Port port = 0;
        for (const Node other : all.neighbours(node)) {
            // Between two catoms of this process the first one links.
            if (there(other) && (owner[other] != process || node < other))
                members.ensemble.links().connect(static_cast<Catom>(catom_of[node]), port, static_cast<Catom>(catom_of[other]),
                                                 port_towards(all, other, node));
            ++port;
        }
    }
    for (const JoinedNodes& link : joined) {
        if (!there(link.a) || !there(link.b) || (owner[link.a] != process && owner[link.b] != process)) continue;
        const auto a = static_cast<Catom>(catom_of[link.a]), b = static_cast<Catom>(catom_of[link.b]);
        members.ensemble.links().room(a, link.port_of_a + 1);
        members.ensemble.links().room(b, link.port_of_b + 1);
        if (!members.ensemble.links().at(a, link.port_of_a) && !members.ensemble.links().at(b, link.port_of_b))
            members.ensemble.links().connect(a, link.port_of_a, b, link.port_of_b);
    }
    MELD_ENSURE(members.ensemble.owned_count() == mine.size() && members.ensemble.ghost_count() == ghosts.size(), "{} nodes", nodes);
}

}  // namespace meld::sim
