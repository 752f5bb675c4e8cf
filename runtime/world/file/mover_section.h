// What moves by a script in worlds of bodies: [[motion.mover]], obstacles, and [motion.gravity_swing].
#pragma once

#include "runtime/world/description/physics_options.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// How something moves, by these keys of its table, whose section reads them: swing, tilt, frequency, phase, spin and pivot.
void read_prescribed(TomlReader& reader, const Section& section, const toml::table& table, PrescribedOptions& motion);
// All movers of the table [motion], and the swing of gravity.
void read_movers(TomlReader& reader, const toml::table& motion, PhysicsOptions& p);

}  // namespace meld::world
