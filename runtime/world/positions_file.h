// Lists of positions in CSV files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/physics_options.h"

namespace meld::world {

// Adds lines of three numbers with commas between them, and as many more as a first line of words names columns behind x, y, z:
// `radius` and `mass`, in any order. Empty lines, and lines that start with '#', are passed over. `path` is for messages. Errors
// name line and column.
Result<void> add_positions(std::string_view text, const std::string& path, std::vector<PlacedCatom>& placed);

}  // namespace meld::world
