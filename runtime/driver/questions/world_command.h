// `meldsim world`: what a world file describes.
#pragma once

#include "runtime/driver/setup/options.h"

namespace meld::driver {

// Prints the size of the world and its target and the memory that its catoms take, and reports every reason why a run could not start that
// can be found without a program. Takes a picture of the start if there is to be one. Returns the exit code.
int world_command(const WorldOptions& options);

}  // namespace meld::driver
