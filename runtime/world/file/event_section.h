// [[event]] and [faults] of a world file.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "runtime/world/description/world.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// [[event]] tick = 10 (or time = "5ms"), every = 5, times = 3, and what happens:
//   give = { NAME = ... }, take = { NAME = ... }     each as in [facts]
//   kill, hang, restart = REGION, the number of a catom, or several of both
//   cut, heal = REGION, { between = [REGION, REGION] }, [[3, 4], ...], or several of these
//   join = [[3, 4], ...]
//   jam = { where or between = as above, ticks = N }, or several
// The rest of the world has been read.
void read_events(TomlReader& reader, const toml::table& top, World& world);

// [faults] kill, hang, restart, cut, heal = P, where = REGION, from = T, until = T; or several, [[faults]].
void read_faults(TomlReader& reader, const toml::table& top, World& world);

// How late jams can make a message: those that follow each other, or that a catom which pauses can meet one after the other, count as one,
// wherever they are. Nothing if there are too many of them.
std::optional<std::int64_t> longest_jam(std::span<const Event> events, const ClockOptions& clock);

// Whether anything of these is for catoms that are known by their links.
bool needs_links(const toml::table& top);

}  // namespace meld::world
