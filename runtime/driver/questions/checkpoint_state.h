// The state in a checkpoint, for somebody who looks at it and does not go on.
#pragma once

#include <memory>

#include "runtime/driver/setup/options.h"
#include "runtime/results/compare/compare.h"

namespace meld::driver {

// Loads the program's module, its world and the catoms, on one process. Errors: the program or the world has changed since the
// checkpoint was made, or the checkpoint is damaged (exit code 6). Cost: as much memory as the run.
Result<std::unique_ptr<compare::State>> load_state(const sim::Checkpoint& checkpoint, const ParseRun& parse);

}  // namespace meld::driver
