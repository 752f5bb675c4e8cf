// How catoms on a lattice can move: [motion] moves = "pivoting", and [[motion.move]].
#pragma once

#include "runtime/world/description/world.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// `motion`: the section, of which `kind` has been read into the world. Sets World::motion.moves if the section says anything of them.
void read_moves(TomlReader& reader, const Section& motion, World& world);

}  // namespace meld::world
