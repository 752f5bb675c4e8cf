// What the files of a graph say about its links and nodes, as facts.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// Gives link(A, B, ...) to each catom A with a link to B, for each predicate `link` that the program declares and may be given: its further
// arguments are the first columns of the file. In a directed graph only links from A to B count. A column of the nodes is given to the
// predicate of its name that has one argument. Errors: the file has fewer columns, or values of another type; the program senses cells; an
// aggregate waits for more neighbours than it can. `only`: no others.
Result<void> give_graph_facts(Subdomain& subdomain, const std::vector<Catom>* only = nullptr);

// Whether the graph gives facts of a predicate of this name.
bool graph_gives(const world::World& world, std::string_view name);

}  // namespace meld::sim
