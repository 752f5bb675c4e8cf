// What bodies look like: the keys of a table that say so, and the compounds that a world defines.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "runtime/world/description/physics_options.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// The form that a table describes, if it describes any: a solid, or one of these compounds by its name.
std::optional<BodyForm> read_form(const Section& section, std::span<const CompoundForm> compounds);

// [[motion.compound]]: bodies of several solids, each a [[motion.compound.part]].
void read_compounds(TomlReader& reader, const toml::table& motion, std::vector<CompoundForm>& compounds);

// The least thickness of a form, in diameters of the world, if its keys say so; that of others is that of the catom.
std::optional<double> thickness_of(const BodyForm& form, std::span<const CompoundForm> compounds);

}  // namespace meld::world
