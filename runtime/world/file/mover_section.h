// What moves by a script in worlds of bodies: [[motion.mover]] and [motion.gravity_swing].
#pragma once

#include "runtime/world/description/physics_options.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// All of them of the table [motion].
void read_movers(TomlReader& reader, const toml::table& motion, PhysicsOptions& p);

}  // namespace meld::world
