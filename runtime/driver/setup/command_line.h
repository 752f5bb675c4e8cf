// The command line of `meldsim run` that has given options, or would give them.
#pragma once

#include <string>
#include <vector>

#include "runtime/driver/setup/options.h"

namespace meld::driver {

// By which the processes of the run are started and its checkpoints know it.
std::vector<std::string> command_line(const RunOptions& run);

}  // namespace meld::driver
