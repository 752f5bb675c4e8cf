// The section [motion] of a world whose catoms are bodies.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "runtime/world/description/physics_options.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

struct DescribedRobots;

// [motion] kind = "bodies", without the key `kind` itself. Diameters in metres: the world's, and that of the smallest catom as far as it is
// known without this section. What robots consist of comes before what [[motion.catoms]] and [[motion.joint]] say, which override it.
void read_physics(TomlReader& reader, const toml::table& table, double diameter_m, double smallest_m, const DescribedRobots& robots,
                  PhysicsOptions& physics);

// The keys of [[motion.catoms]] that say what a body is like, and reading them: parts of an assembly have them, too.
const std::vector<std::string_view>& body_keys();
void read_body_keys(const Section& section, std::span<const CompoundForm> compounds, CatomGroup& group);

}  // namespace meld::world
