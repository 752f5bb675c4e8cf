// Lists of positions in CSV files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/lattice.h"

namespace meld::world {

// Adds lines of three numbers with commas between them; a first line of words, empty lines, and lines that start with '#' are
// passed over. `path` is for messages. Errors name line and column.
Result<void> add_positions(std::string_view text, const std::string& path, std::vector<Vec3>& positions);

}  // namespace meld::world
