// Lists of positions in CSV files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/physics_options.h"

namespace meld::world {

// Adds lines of three numbers separated by commas, plus as many as a first line of words names columns after x, y, z: `radius` and `mass`,
// in any order. Skips empty lines and lines that start with '#'. `path` is for messages. Errors name line and column.
Result<void> add_positions(std::string_view text, const std::string& path, std::vector<PlacedCatom>& placed);

}  // namespace meld::world
