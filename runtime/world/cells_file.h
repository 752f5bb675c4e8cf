// Lists of cells in CSV files.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/lattice.h"

namespace meld::world {

// A cell and where it was written, "cells.csv:3" or "world.toml:4:9".
struct ListedCell {
    Cell cell;
    std::string place;
};

// Lines of three integers with commas between them, or two on a flat lattice; a first line of words, empty lines, and lines
// that start with '#' are passed over. `path` is for messages. Errors name line and column.
Result<std::vector<ListedCell>> parse_cells(std::string_view text, const std::string& path, const Lattice& lattice);

// The cell with these coordinates, if it is one of the lattice; errors say why not, without the place.
Result<Cell> checked_cell(const std::vector<std::int64_t>& coordinates, const Lattice& lattice);

// Sorts by key. Errors: a cell is listed twice, with both places.
Result<std::vector<Cell>> sorted_cells(std::vector<ListedCell> listed, const Lattice& lattice);

}  // namespace meld::world
