// `meldsim debug`: walks through a run, forward and back, and tells what holds (runtime/ask/debug).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/run/configuration_agreement.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/driver/setup/options.h"

namespace meld::driver {

// Of a program, a recording or a folder of checkpoints, which is in RunOptions::program. `scratch` is as in ReplayOptions; `parse` reads a
// command line of `meldsim run`. Returns the exit code; prints its own messages.
int debug_command(RunOptions options, std::string scratch, const ParseRun& parse);

// The session, on every process, when it is known what is run; what is done by hand is added to the world. Returns the exit code. Errors:
// of a command that was not typed at a terminal; a signal has asked for the end.
Result<int> debug_run(const RunOptions& options, Inputs& inputs, const std::vector<Claim>& claims, comm::Communicator& comm);

}  // namespace meld::driver
