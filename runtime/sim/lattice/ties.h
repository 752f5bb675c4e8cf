// What keeps an ensemble in one piece when a catom moves (docs/motion.md, "Staying connected").
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "runtime/world/lattice/lattice.h"

namespace meld::sim {

// Catoms are searched so many cells from the mover's old cell, in each coordinate; where a move can end is no further.
inline constexpr std::int32_t kTieReach = 2;

// The cells of catoms that hold together, without the mover, the neighbours that it leaves and its new cell: a tree of shortest paths from
// there. It has all of those neighbours, but neither the old cell nor the new one. As long as all of these catoms stay where they are, the
// ensemble is still connected after the move. None if they are not connected within the reach: a catom cannot know more without asking
// others. `full` says whether a cell is occupied before the move.
std::optional<std::vector<world::Cell>> ties(const world::Lattice& lattice, const std::function<bool(world::Cell)>& full, world::Cell from,
                                             world::Cell to);

}  // namespace meld::sim
