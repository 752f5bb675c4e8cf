// Obstacles: [[motion.obstacle]] of bodies, and [[links.obstacle]], what is in the way of points that see each other.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "runtime/world/description/physics_options.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

void read_surface(const Section& section, std::optional<double>& friction, std::optional<double>& restitution);

enum class Touched { Yes, No };
// The tables [[OWNER.obstacle]] of a table [OWNER]. Those that nothing touches have no friction and no restitution.
void read_obstacles(TomlReader& reader, const toml::table& table, std::string_view owner, Touched touched,
                    std::vector<ObstacleOptions>& all);

}  // namespace meld::world
