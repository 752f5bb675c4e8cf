// The worlds of random trials, with their networks and clocks.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "runtime/world/description/world.h"
#include "runtime/world/graph/graph.h"
#include "tests/retraction/case.h"

namespace meld::reference {

// Where a case begins: its seed, and its lattice and cells or its graph.
world::World make_world(const retraction::Case& c);
// Of a case that is one. With places.
std::shared_ptr<const graph::Graph> make_graph(const retraction::Case& c);

// Sets a network and a clock that follow from a number; 0: an ideal network, and all catoms act in every tick. Messages are delayed, lost
// and sent again, but links do not go down in any time that a trial lasts.
void set_conditions(world::World& world, std::uint64_t number);
// Links are in a table, and in half of the worlds that are not ideal, by a number, they are jammed for a while.
void set_jams(world::World& world, std::uint64_t number);
// In words.
std::string describe_conditions(std::uint64_t number);

}  // namespace meld::reference
