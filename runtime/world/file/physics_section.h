// The section [motion] of a world whose catoms are bodies.
#pragma once

#include "runtime/world/description/physics_options.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// [motion] kind = "bodies", without the key `kind` itself. Diameters in metres: the world's, and that of the smallest catom as far as it is
// known without this section.
void read_physics(TomlReader& reader, const toml::table& table, double diameter_m, double smallest_m, PhysicsOptions& physics);

}  // namespace meld::world
