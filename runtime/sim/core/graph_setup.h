// The set-up of a subdomain whose catoms are the nodes of a graph.
#pragma once

#include <vector>

#include "runtime/comm/communicator.h"
#include "runtime/graph/graph.h"
#include "runtime/sim/core/membership.h"

namespace meld::sim {

// Places the nodes that this process owns, and a ghost for each neighbour that another one owns. Collective: the first process decides who
// owns what, and tells the others. `left`: only these nodes; the others have been killed, and the ports that led to them are vacant. Cost:
// linear in the links of the whole graph, with several processes some microseconds each; 12 bytes for each end of a link that a process
// knows.
void populate_graph(Membership& members, const graph::Graph& graph, comm::Communicator& comm, const std::vector<bool>* left = nullptr);

}  // namespace meld::sim
