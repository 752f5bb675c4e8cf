// `meldsim shot --steps` and `meldsim movie --steps`: pictures of the steps of a recording as they are.
#pragma once

#include "runtime/driver/setup/options.h"

namespace meld::driver {

// Makes the picture or the film, and prints what it is or what is wrong; no run is made. Returns the exit code. Call it once, before there
// are other threads. Memory: one step, and the frames that are painted side by side.
int paint_steps(const RunOptions& options);

}  // namespace meld::driver
