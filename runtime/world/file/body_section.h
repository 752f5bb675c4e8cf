// [[body]] and [without]: where catoms stand, and lists of cells.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "runtime/world/file/assembly_section.h"
#include "runtime/world/lists/cells_file.h"

namespace meld::world {

// All bodies of a world, robots among them. There is at least one.
void read_bodies(TomlReader& reader, const Section& top, DescribedRobots& robots, World& world);

// cells = an array or a file name, in a section of this name.
void read_cells(TomlReader& reader, const Section& section, std::string_view name, CellList& listed);

// Balls that hold the middle of their cell and of no other.
Shape around_each(const std::vector<Cell>& cells, const Lattice& lattice, const std::string& text);

}  // namespace meld::world
