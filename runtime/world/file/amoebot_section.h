// The section [motion] of a world of amoebots.
#pragma once

#include "runtime/world/description/world.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// Whether the world's [motion] has kind = "amoebot"; the rest need not be right.
bool says_amoebots(const toml::table& top);
void read_amoebots(TomlReader& reader, const toml::table& table, MotionOptions& motion);
// Amoebots live on the triangular lattice, hold no units and read their neighbours as they are.
void check_amoebots(TomlReader& reader, const Section& top, const World& world);

}  // namespace meld::world
