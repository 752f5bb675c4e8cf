// [[motion.joint]], [[assembly.joint]] and [[motion.joint_kind]]: joints between catoms that are bodies, at the start and when programs
// make them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "runtime/world/description/physics_options.h"
#include "runtime/world/file/toml_reader.h"
#include "runtime/world/shapes/robots.h"

namespace meld::world {

void read_joint(TomlReader& reader, const toml::table& table, JointOptions& joint);
void read_joint_kind(TomlReader& reader, const toml::table& table, JointOptions& kind);
// [[assembly.joint]]: `between` are the numbers of two of its parts; its anchor and axis are those of the robot.
void read_assembly_joint(TomlReader& reader, const toml::table& table, const Assembly& assembly, JointOptions& joint);
// ["hull", "left"]: the numbers of two parts under a key. Errors: it is something else, they are one part, the assembly has no such part.
std::optional<std::array<std::uint32_t, 2>> read_two_parts(TomlReader& reader, const toml::node& node, const Assembly& assembly);

}  // namespace meld::world
