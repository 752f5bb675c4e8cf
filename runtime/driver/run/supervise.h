// Starts the processes of a run, and with --checkpoint again when they were killed, crashed or hang: from the last checkpoint.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/comm/launch/launch.h"
#include "runtime/driver/setup/options.h"

namespace meld::driver {

// Whether a run with these options is supervised, if it is not one of the processes of a run itself.
bool is_supervised(const RunOptions& options);

// Runs the processes until they end in a way that another start would not change. Returns the exit code of the command, of which it tells.
int supervise(RunOptions options, const std::string& module);

// Of a process that is supervised: what has happened to the run before. Call it once, before other threads start.
std::vector<Restart> restarts_so_far();

// The command line of a process that goes on with the run in this folder.
std::vector<std::string> resume_arguments(const std::string& folder, const RunOptions& options);

// Seconds, from "60s" or "off", which is 0. Errors: anything else.
Result<double> parse_heartbeat(std::string_view text);

}  // namespace meld::driver
