// A run in one of its processes: from its inputs to its report.
#pragma once

#include <string>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/setup/options.h"

namespace meld::driver {

// Everything after the processes have started and the program has been compiled. Every process calls it. Returns the exit code; errors that
// all processes share are reported only by process 0.
Result<int> simulate(const RunOptions& options, comm::Communicator& comm, const std::string& module_path);

}  // namespace meld::driver
