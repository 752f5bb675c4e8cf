// How many catoms begin in each brick: what a run counts first, for how much memory it needs and for who owns what.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/world/description/world.h"
#include "runtime/world/lattice/lattice.h"

namespace meld::sim {

// Sorted; the same on every process.
using BrickCounts = std::vector<std::pair<world::BrickKey, std::uint32_t>>;

// Every process counts its part of the bricks on its workers, and all get all counts. Collective. Cost: as for world::count_bricks, divided
// by the processes.
BrickCounts count_together(const world::World& world, const world::Lattice& lattice, comm::Communicator& comm, Workers& workers);

// The same, before anything is made: nothing for a world that may be too large to be counted in every run that it does not fit. Errors: the
// world has no catoms. Starts its own threads, `threads` with the caller.
Result<std::optional<BrickCounts>> count_beforehand(const world::World& world, comm::Communicator& comm, int threads);

}  // namespace meld::sim
