// From a world to its catoms: which bricks the body reaches, how many catoms each contains, and on which cells.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "runtime/base/process/parallel_for.h"
#include "runtime/world/description/world.h"
#include "runtime/world/lattice/lattice.h"

namespace meld::world {

// One bit for each of a brick's 512 cells.
using BrickCells = std::array<std::uint64_t, kBrickCells / 64>;

// The cells of a brick that lie in a shape. Cost: nothing for a brick wholly inside or outside, otherwise one test per cell.
BrickCells cells_in_shape(const Shape& shape, const Lattice& lattice, Cell brick);

// The cells of a brick that the body contains, by its shapes or its list of cells.
BrickCells cells_of_body(const World& world, const Lattice& lattice, Cell brick);

// Calls visit(brick) for each brick that a shape may reach, in an order that is the same on every process, until it returns false. Skips
// space that the shape does not reach in large pieces, and lists nothing beforehand.
void for_each_brick(const Shape& shape, const Lattice& lattice, const std::function<bool(Cell brick)>& visit);

// The number of catoms in each brick that has any, for share number `share` of `shares` equal shares of the bricks: every brick with a
// catom is in exactly one share. Sorted by key. Cost: some 10 ns a catom near the body's surface, next to nothing for those inside, divided
// by the workers if there are any; in addition, each share walks over all bricks, 0.1 us each.
std::vector<std::pair<BrickKey, std::uint32_t>> count_bricks(const World& world, const Lattice& lattice, int share, int shares,
                                                             Workers* workers = nullptr);

// The cells of the body in one brick, as numbers in the brick, ascending; `cells` is emptied first.
void cells_of_brick(const World& world, const Lattice& lattice, BrickKey brick, std::vector<std::uint32_t>& cells);

// The number of catoms in the world. Cost: as for count_bricks.
std::uint64_t count_catoms(const World& world, const Lattice& lattice);

}  // namespace meld::world
