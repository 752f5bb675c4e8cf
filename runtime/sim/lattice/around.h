// The ways of a catom around a neighbour, on each lattice: sliding cubes turn round its edges, discs and spheres roll.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "runtime/world/lattice.h"

namespace meld::sim {

// A move to a place beside a catom, and what it needs.
struct WayAround {
    world::Cell to;
    int direction = 0;                // Different for different ways of a catom.
    std::vector<world::Cell> empty;   // Cells that must be and stay empty, the last one among them; each once.
    std::vector<world::Cell> bodies;  // Catoms that must stand still.
};

// The shortest way of the catom at `mover` around the catom at its port `pivot` to a cell beside the catom at `beside`, which
// is neither; of ways as short, along the pivot before around it, and then the one to the lowest port of the pivot.
// The mover's own cell counts as empty. Cost: some hundred questions.
std::optional<WayAround> way_around(const world::Lattice& lattice, const std::function<bool(world::Cell)>& full, world::Cell mover,
                                    int pivot, world::Cell beside);

}  // namespace meld::sim
