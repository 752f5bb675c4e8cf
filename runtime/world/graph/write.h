// A graph as the CSV files that a world reads it from.
#pragma once

#include <functional>
#include <string_view>

#include "runtime/base/error.h"
#include "runtime/world/graph/graph.h"

namespace meld::graph {

using Put = std::function<void(std::string_view)>;

// A line of names, then one for each link: the numbers of its ends and its columns. Of an undirected graph each link is there once.
// Errors: a word has a line break, which such a file cannot have. Cost: linear.
Result<void> write_links(const Graph& graph, const Put& put);
// The same of nodes: their numbers, their places and their columns.
Result<void> write_nodes(const Graph& graph, const Put& put);

}  // namespace meld::graph
