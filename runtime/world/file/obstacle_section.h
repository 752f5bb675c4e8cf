// Obstacles: [[motion.obstacle]] of bodies, and [[links.obstacle]], what is in the way of points that see each other.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "runtime/world/description/physics_options.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// What contacts need to know of a surface; friction against turning is by the radius of the patch, in diameters.
struct SurfaceKeys {
    std::optional<double>&friction, &restitution, &rolling_friction, &spinning_friction;
};
void read_surface(const Section& section, const SurfaceKeys& surface);

enum class Touched { Yes, No };
// The tables [[OWNER.obstacle]] of a table [OWNER]. Those that nothing touches have no friction and no restitution. They may be
// `compounds`, by their names.
void read_obstacles(TomlReader& reader, const toml::table& table, std::string_view owner, Touched touched,
                    std::span<const CompoundForm> compounds, std::vector<ObstacleOptions>& all);

}  // namespace meld::world
