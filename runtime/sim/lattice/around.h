// The paths of a catom around a neighbour, on each lattice: sliding cubes turn around its edges, discs and spheres roll.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "runtime/world/lattice/lattice.h"

namespace meld::sim {

// A move to a cell beside a catom, and its requirements.
struct WayAround {
    world::Cell to;
    int direction = 0;                // Distinguishes the paths of one catom.
    std::vector<world::Cell> empty;   // Cells that must be and stay empty, including the last one; each once.
    std::vector<world::Cell> bodies;  // Catoms that must stand still.
};

// The shortest path of the catom at `mover` around the catom at its port `pivot` to a cell beside the catom at `beside`, which is neither;
// of paths of equal length, slides along the pivot first, then the path to the lowest port of the pivot. The mover's own cell counts as
// empty. Cost: some hundred lookups of cells.
std::optional<WayAround> way_around(const world::Lattice& lattice, const std::function<bool(world::Cell)>& full, world::Cell mover,
                                    int pivot, world::Cell beside);

}  // namespace meld::sim
