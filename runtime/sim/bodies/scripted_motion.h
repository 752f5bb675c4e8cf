// What a world says of gravity over time.
#pragma once

#include <cstdint>

#include "physics/bodies/types.h"
#include "runtime/world/description/world.h"

namespace meld::sim {

// In the step after so many, counted from 0 through all ticks: that of the world, or of the last event up to the tick of the step (of
// several in one tick, the last in the file), with the swing. m/s^2.
physics::Vec3 gravity_in_step(const world::World& world, std::uint64_t step);
// The greatest in a run, or somewhat more where it swings.
double greatest_gravity(const world::World& world);
// Whether it may be another than at the start.
bool changes_gravity(const world::World& world);

}  // namespace meld::sim
