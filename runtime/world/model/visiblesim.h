// Configurations of VisibleSim, the simulator of programmable matter, as worlds.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"

namespace meld::model {

struct ImportedWorld {
    std::string text;  // A world, in TOML.
    std::size_t cells = 0, target_cells = 0;
    std::vector<std::string> left_out;  // What of the configuration a world has no place for.
};

// The modules that an XML configuration lists as block, blocksLine and blockBox, in the cells where VisibleSim puts them, and the cells of
// its first target (targetGrid, targetList); ports have the numbers of VisibleSim's modules. `lattice` is that
// of the modules, which the configuration does not name: square for SmartBlocks, hex for Catoms2D, cubic for BlinkyBlocks, fcc for
// Catoms3D. `path` is for messages and a comment. Errors name the line: it is not XML, or not a configuration; modules that are computed
// (csg, mesh), outside of the grid, or two in one cell.
Result<ImportedWorld> import_visiblesim(std::string_view xml, const std::string& path, std::string_view lattice);

}  // namespace meld::model
