// The commands of meldsim and their options.
#pragma once

namespace meld::driver {

// Reads a command line and does what it says. Returns the exit code.
int run_meldsim(int argc, char** argv);

}  // namespace meld::driver
