// Whether a program that is given no world runs in a graph of the nodes and links that its text names.
#pragma once

#include "compiler/check/program/program.h"

namespace meld::check {

// `finds_ways`: some rule makes facts at a node that no link of its body leads to, known by value or made by the rule. Assumes resolved
// rules. The runtime adds one reason, which needs the geometry of the default world: a link between catoms that do not touch there.
bool runs_in_own_graph(const Program& program, bool finds_ways);

}  // namespace meld::check
