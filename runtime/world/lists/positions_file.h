// Lists of positions in CSV and NumPy files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/description/physics_options.h"

namespace meld::world {

// Adds the rows of a NumPy file: x, y, z, and if there are five columns radius and mass. Or lines of three numbers
// separated by commas, plus as many as a first line of words names columns after x, y, z: `radius` and `mass`, in any order. Skips
// empty lines and lines that start with '#'. `path` is for messages. Errors name line and column.
Result<void> add_positions(std::string_view text, const std::string& path, std::vector<PlacedCatom>& placed);

// A robot that stands somewhere, in diameters, turned about a vector by its length in degrees.
struct RobotPlace {
    Vec3 at{}, turned{};
};
// Adds the rows of such a file that are places of robots: three or six columns, the last of which, turned_x, turned_y and turned_z, say
// how a robot is turned. Errors as above.
Result<void> add_robot_places(std::string_view text, const std::string& path, std::vector<RobotPlace>& places);

}  // namespace meld::world
