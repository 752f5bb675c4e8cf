// `meldsim shot`: a picture of a run at one tick or at several.
#pragma once

#include "runtime/base/error.h"
#include "runtime/driver/onlooker.h"
#include "runtime/driver/options.h"
#include "runtime/world/world_file.h"

namespace meld::driver {

// Goes to each tick and takes the picture. Every process calls it.
Result<int> take_shot(const RunOptions& options, const world::World& world, Onlooker& onlooker);

}  // namespace meld::driver
