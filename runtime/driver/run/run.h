// `meldsim run`: compile if needed, start the processes, run, report.
#pragma once

#include <string>

#include "runtime/base/error.h"
#include "runtime/driver/setup/options.h"

namespace meld::driver {

// Returns the exit code of the command. Prints its own messages, from process 0 only.
int run_command(RunOptions options);

// `meldsim resume`: goes on with the run whose checkpoints are in a folder, in the folder where it was started.
int resume_command(const ResumeOptions& resume, const ParseRun& parse);

// The module of a program: compiled by the meldc beside this program, from its cache if it was compiled before.
// Errors carry meldc's exit code; its messages have been printed by then, or are in `messages`, also if there is no error.
Result<std::string> compile_program(const RunOptions& options, std::string* messages = nullptr);

}  // namespace meld::driver
