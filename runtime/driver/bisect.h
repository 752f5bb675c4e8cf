// `meldsim bisect`: the first tick in which a Meld body holds at some catom, or no longer does.
#pragma once

#include "runtime/base/error.h"
#include "runtime/driver/inputs.h"
#include "runtime/driver/options.h"
#include "runtime/sim/simulation.h"

namespace meld::driver {

// Runs a simulation that has been started until its question is answered, and prints the answer. The program was compiled with the body
// (runtime/abi/question.h). Every process calls it. Returns the exit code: 0 if there is such a tick, 3 if the run ends without one, 130
// if it was interrupted. Errors: those of the run. Cost: one run, and a look at each catom after every tick; for the
// derivation of the witness a second run to that tick, with snapshots.
Result<int> find_tick(const RunOptions& options, const Inputs& inputs, sim::Simulation& simulation);

}  // namespace meld::driver
