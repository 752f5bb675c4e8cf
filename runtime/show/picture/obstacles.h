// What stands in the way of bodies, as triangles for pictures.
#pragma once

#include <cstdint>

#include "runtime/show/render/scene.h"
#include "runtime/world/description/world.h"

namespace meld::picture {

// Puts the obstacles of a world with bodies into a scene that has its catoms, where they are at the end of a tick, 0: before the first one.
// A floor that is level and stays is `ground`, of other planes a piece below and around the catoms. Does nothing for other worlds. Cost:
// that of the triangles, each time.
void add_obstacles(const world::World& world, std::int64_t tick, render::Scene& scene);

// A piece of the floor, for those who draw no shadows: below the catoms and around them, as two triangles. Nothing without a floor.
std::vector<render::Triangle> floor_of(const render::Scene& scene);

}  // namespace meld::picture
