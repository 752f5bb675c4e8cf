// What the command line asks to be watched: --watch, --expect and --never.
#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include "runtime/ask/watch/watches.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/driver/setup/options.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/sim/simulation.h"

namespace meld::driver {

// Whether the text of a --watch is a file of rules, and not a body.
bool names_watch_file(const std::string& text);

// Null: nothing. Errors: a file cannot be read; mistakes in it or in a body.
Result<std::unique_ptr<inspect::Watches>> make_watches(const RunOptions& options, const ModuleInfo& module, std::FILE* to);

// Says why a watch that has just found the run not as wanted did so, if the run can be saved: in a copy of its state, so the run is not
// changed. Earlier states are not looked at. Every process calls it. Errors: those of inspect::why_body(); the lines cannot be written.
// Cost: that of a snapshot, of a run from it, and of its derivation.
Result<void> explain_caught(inspect::Watches& watches, sim::Simulation& simulation, const RunOptions& options, const Inputs& inputs,
                            comm::Communicator& comm);

}  // namespace meld::driver
