// Worlds whose catoms are points: nodes with places, linked while they are within a range, and perhaps moving.
#pragma once

#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// Whether links is a table: [links] range = 3.
bool links_by_range(const Section& top);
// lattice = "graph" with such links: the points, from a generator or a file, and [links] with [links.noise].
void read_point_world(TomlReader& reader, const Section& top, World& world);
// [links] and [links.noise].
void read_range(TomlReader& reader, const toml::table& table, World& world);
// [motion] kind = "points".
void read_points(TomlReader& reader, const toml::table& table, MotionOptions& motion);
// Nodes move only where their links follow from their places.
void check_moving(TomlReader& reader, const Section& top, const World& world);

}  // namespace meld::world
