// Errors of command lines, as shown to the user: the option, its value and what is allowed, or the name that was probably meant.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/cli/command_line.h"

namespace meld::cli {

// The commands that users see.
std::vector<std::string> command_names(const CLI::App& app);

// Each function reports one error on standard error and returns the exit code. `where` is the program with its command, "meldsim run".
int usage_error(const std::string& where, const Error& error);
int no_such_command(const CLI::App& app, const std::string& name, const Elsewhere& elsewhere);
// If the parser refuses a command line with several errors, reports the one that explains the others: an unknown command or option before
// the values and arguments that are then too many or too few.
int report_usage(const CLI::App& app, const CLI::ParseError& error, int argc, const char* const* argv, const Elsewhere& elsewhere);

}  // namespace meld::cli
