// [[motion.joint]] and [[motion.joint_kind]]: joints between catoms that are bodies, at the start and when programs make them.
#pragma once

#include "runtime/world/description/physics_options.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

void read_joint(TomlReader& reader, const toml::table& table, JointOptions& joint);
void read_joint_kind(TomlReader& reader, const toml::table& table, JointOptions& kind);

}  // namespace meld::world
