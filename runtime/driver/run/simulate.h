// A run in one of its processes: from its inputs to its report.
#pragma once

#include <string>

#include "runtime/ask/watch/watches.h"
#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/setup/memory_need.h"
#include "runtime/driver/setup/options.h"
#include "runtime/sim/simulation.h"

namespace meld::driver {

// Sees a run from within, for whoever makes it by a call.
class RunObserver {
  public:
    virtual ~RunObserver() = default;
    // When the catoms have been counted, and before memory is taken for them. Errors end the run.
    virtual Result<void> need(const MemoryNeed&) { return {}; }
    // Before the run is set up: it may add modules.
    virtual void begin(sim::Simulation& simulation) = 0;
    // After the last tick, when it is known whether what was expected holds; of a run that has failed right after that. Nothing is watched:
    // null. Errors make the run fail.
    virtual Result<void> end(sim::Simulation& simulation, const inspect::Watches* watches, bool failed) = 0;
};

// Everything after the processes have started and the program has been compiled. Every process calls it. Returns the exit code; errors that
// all processes share are reported only by process 0.
Result<int> simulate(const RunOptions& options, comm::Communicator& comm, const std::string& module_path, RunObserver* observer = nullptr);

}  // namespace meld::driver
