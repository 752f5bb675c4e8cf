// Circles along the directions of a graph.
#pragma once

#include <vector>

#include "runtime/world/graph/graph.h"

namespace meld::graph {

// The nodes of one circle, each linked to the next and the last to the first; none: there is no circle. In an undirected graph each link is
// one. The same for the same graph. Cost: linear, and 12 bytes a node.
std::vector<Node> cycle(const Graph& graph);

}  // namespace meld::graph
