// The set-up of a subdomain whose catoms are the nodes of a graph.
#pragma once

#include <span>
#include <vector>

#include "runtime/comm/transport/communicator.h"
#include "runtime/sim/catoms/membership.h"
#include "runtime/world/graph/graph.h"

namespace meld::sim {

// A link of nodes that the graph does not have; its ports are beyond those of the graph.
struct JoinedNodes {
    graph::Node a = 0, b = 0;
    world::Port port_of_a = 0, port_of_b = 0;
};

// All links of a graph, as those of nodes that move: at the ports that they would have in the graph.
std::vector<JoinedNodes> first_links(const graph::Graph& graph);

// Places the nodes of members.nodes that this process owns, and a ghost for each neighbour that another one owns. Collective: the first
// process decides who owns what, and tells the others. `left`: only these nodes; the others have been killed, and the ports that led to
// them are vacant. Links that are `joined` are made too; links of nodes that are not there, or at ports that are taken, are not. Cost:
// linear in the links of the whole graph, with several processes some microseconds each; 8 bytes for each end of a link that a process
// knows, 12 where links are read apart.
void populate_graph(Membership& members, const graph::Graph& graph, comm::Communicator& comm, const std::vector<bool>* left = nullptr,
                    std::span<const JoinedNodes> joined = {});

}  // namespace meld::sim
