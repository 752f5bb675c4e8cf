// The lamps of a world that stand somewhere, for pictures.
#pragma once

#include "runtime/show/render/scene.h"
#include "runtime/world/description/world.h"

namespace meld::picture {

// Puts those lamps of a world with bodies into a scene that have a position and shine; catoms that carry lamps look like others. A ball of
// 0.4 diameters each. Does nothing for other worlds.
void add_lamps(const world::World& world, render::Scene& scene);

}  // namespace meld::picture
