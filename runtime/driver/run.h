// `meldsim run`: compile if needed, start the parts, run, report.
#pragma once

#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/options.h"

namespace meld::driver {

// Returns the exit code of the command. Prints what it has to say itself, from part 0 alone.
int run_command(RunOptions options);

// The module of a program: compiled by the meldc beside this program, from its cache if it was compiled before.
// `link` are the C files of its externs, `library_paths` the folders of its includes and libraries. Errors carry meldc's exit code; its messages have been printed by then.
Result<std::string> compile_program(const std::string& program, const std::vector<std::string>& link = {}, const std::vector<std::string>& library_paths = {});

}  // namespace meld::driver
