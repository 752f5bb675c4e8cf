// Errors of command lines as the user reads them: the option, its value and what is allowed, or the name that was probably meant.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/cli/command_line.h"

namespace meld::cli {

// The commands that users see.
std::vector<std::string> command_names(const CLI::App& app);

// Each reports one error on standard error and returns the exit code. `where` is the program with its command, "meldsim run".
int usage_error(const std::string& where, const Error& error);
int no_such_command(const CLI::App& app, const std::string& name, const Elsewhere& elsewhere);
// Of all that is wrong with a command line that the parser refused, reports what explains the rest: an unknown command or option
// before the values and arguments that then are too many or too few.
int report_usage(const CLI::App& app, const CLI::ParseError& error, int argc, const char* const* argv, const Elsewhere& elsewhere);

}  // namespace meld::cli
