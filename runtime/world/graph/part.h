// A part of a graph: some of its nodes, and some of its links.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/world/graph/graph.h"

namespace meld::graph {

// A link of a graph: one of its nodes, and the entry of Graph::to that leads to the other.
struct Entry {
    Node node = 0;
    std::uint64_t at = 0;
    bool operator==(const Entry&) const = default;
};

// Each link once, in order: of an undirected graph at its lower node, of a directed one where it leads away.
std::vector<Entry> entries(const Graph& graph);

// These nodes, in ascending order, and those of these links that are between two of them. Numbers, columns and places stay. Cost: linear.
Graph part(const Graph& graph, const std::vector<Node>& nodes, const std::vector<Entry>& links);

}  // namespace meld::graph
