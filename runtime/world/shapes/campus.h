// The built-in shape campus(size), composed of other shapes.
#pragma once

#include <string_view>

namespace meld::world {

// Two hollow buildings of five and three floors on a plinth, a round tower with a spiral ramp, and a bridge; 100 long. Walls, floors and
// the ramp are two thick, so it is connected on each lattice unless it is made smaller.
inline constexpr double kCampusLength = 100;
inline constexpr std::string_view kCampus =
    "union("
    // The plinth.
    "move(box(100, 64, 3), 0, 0, 1.5),"
    // The tall building: four walls, five floors above the plinth, and a roof.
    "move(minus(box(38, 44, 44), box(34, 40, 44)), -27, 4, 22),"
    "move(box(38, 44, 2), -27, 4, 10), move(box(38, 44, 2), -27, 4, 18), move(box(38, 44, 2), -27, 4, 26),"
    "move(box(38, 44, 2), -27, 4, 34), move(box(38, 44, 2), -27, 4, 43),"
    // The low building, at an angle.
    "rotate(move(minus(box(30, 40, 28), box(26, 36, 28)), 29, -2, 14), z, 8),"
    "rotate(move(union(box(30, 40, 2), move(box(30, 40, 2), 0, 0, 8), move(box(30, 40, 2), 0, 0, 17)), 29, -2, 10), z, 8),"
    // The tower between them: a round wall, a core, and the ramp.
    "move(minus(cylinder(13, 34), cylinder(11, 34)), 1, -12, 17),"
    "move(cylinder(2, 34), 1, -12, 17),"
    "move(helix(8, 10, 3.2, 6), 1, -12, 17),"
    // The bridge from the tall building to the low one.
    "move(minus(box(30, 8, 8), box(30, 4, 4)), 4, 14, 22)"
    ")";

}  // namespace meld::world
