// A world with its catoms, links and events as lists.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/base/error.h"
#include "runtime/driver/shrink/small_world.h"
#include "runtime/driver/shrink/start_catoms.h"

namespace meld::driver {

// Beyond these there are too many to try.
inline constexpr std::size_t kMostListed = 1'000'000;
inline constexpr std::size_t kMostHappenings = 20'000;

// Nodes and links of the graph, or cells and positions of the bodies. False, and nothing is changed: there are too many.
bool list_catoms(SmallWorld& small, const world::World& world, const StartCatoms& start);

// The events of the world, each of its targets for itself, and what its faults strike up to this tick. What events strike by regions stays
// so: see split_regions(). False: there are too many, or nobody knows beforehand what faults strike, and the faults stay.
bool list_events(SmallWorld& small, const world::World& world, const StartCatoms& start, std::int64_t last_tick);

// The same with what happens in a region as what happens to each of its catoms, or links, where nobody moves. False: nothing is split.
bool split_regions(SmallWorld& small, const StartCatoms& start);

// Whether catoms stay where they are, and no others are made.
bool stays_still(const world::World& world, bool makes_nodes);

}  // namespace meld::driver
