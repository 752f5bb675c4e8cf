// The section [motion] of a world whose catoms are bodies.
#pragma once

#include "runtime/world/physics_options.h"
#include "runtime/world/toml_reader.h"

namespace meld::world {

// [motion] kind = "bodies", without the key `kind` itself.
void read_physics(TomlReader& reader, const toml::table& table, PhysicsOptions& physics);

}  // namespace meld::world
