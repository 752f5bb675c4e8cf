// [[motion.joint]]: joints between catoms that are bodies.
#pragma once

#include "runtime/world/description/physics_options.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

void read_joint(TomlReader& reader, const toml::table& table, JointOptions& joint);

}  // namespace meld::world
