// `meldsim movie`: a film of a run.
#pragma once

#include "runtime/base/error.h"
#include "runtime/driver/pictures/frame_observer.h"
#include "runtime/driver/setup/options.h"
#include "runtime/world/description/world.h"

namespace meld::driver {

// Makes the run twice: the values and the places of all frames are to be known before the first is painted, and none is kept. It is made
// once more if it is not said how long it is, or how many ticks there are between frames. Every process calls it.
Result<int> make_movie(const RunOptions& options, const world::World& world, Onlooker& onlooker);

}  // namespace meld::driver
