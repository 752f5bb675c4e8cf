// What a session looks at: a program that is run, the run of a recording, or a run from its newest checkpoint on.
#pragma once

#include <string>

#include "runtime/base/error.h"
#include "runtime/driver/setup/options.h"
#include "runtime/driver/setup/scratch_folder.h"

namespace meld::driver {

// The run of the session, which writes nothing. `options.program` is one of the three; for checkpoints, the folder of their run is entered.
// `own` keeps the files that a recording is made again from, unless they are in `scratch` already. Errors: it cannot be read; options
// that say what is run stand beside what says so itself.
Result<RunOptions> looked_at(RunOptions options, const std::string& scratch, Scratch& own, const ParseRun& parse);

// Errors: options that say what is run, or with which code, stand beside something that says so itself, which is named.
Result<void> carries_its_own(const RunOptions& options, const std::string& what, bool code);

// The run that a viewer shows beside its own: of another program or recording. Errors: it is neither; there are several processes.
Result<RunOptions> looked_at_beside(const RunOptions& options, Scratch& own);

}  // namespace meld::driver
