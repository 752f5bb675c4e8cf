// `meldsim sweep`: the runs of a study, and what they show.
#pragma once

#include "runtime/driver/study/sweep_options.h"

namespace CLI {
class App;
}

namespace meld::driver {

CLI::App* add_sweep(CLI::App& app, SweepOptions& sweep);

// Returns the exit code; prints its own messages.
int sweep_command(const SweepOptions& options);

}  // namespace meld::driver
