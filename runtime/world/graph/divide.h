// Which process owns which node.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/world/graph/graph.h"

namespace meld::graph {

// By node, the part that it belongs to, from 0 to parts - 1: about the same work in each, which is 1 and the links of each node, and few
// links between parts. The same for a graph always, unless METIS fails, which is warned of. From a thread beside which no other writes to
// stderr. Cost: linear; with several parts up to some microseconds a link, and while it runs some
// 80 bytes a link.
std::vector<std::int32_t> divide(const Graph& graph, int parts);

// The links between nodes of different parts.
std::uint64_t cut(const Graph& graph, const std::vector<std::int32_t>& part);

}  // namespace meld::graph
