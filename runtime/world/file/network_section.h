// [network] and [clock] of a world file.
#pragma once

#include "runtime/world/description/network.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

void read_network(TomlReader& reader, const toml::table& table, NetworkOptions& network);
void read_clock(TomlReader& reader, const toml::table& table, ClockOptions& clock);

}  // namespace meld::world
