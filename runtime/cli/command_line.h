// Shared by the command lines of all programs: `help`, `--version`, the nearest name for a mistyped command or option, manual pages and
// completion, all made from the program's table of commands and options.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace meld::cli {

// The possible words of an option or of a command's argument, for completion: from "--emit" or "explain" to the words.
using Choices = std::map<std::string, std::vector<std::string>>;

// The commands of another program that users look for in this one, with that program: from "run" to "meldsim".
using Elsewhere = std::map<std::string, std::string>;

// Checks that the value of an option is a whole number from `least` to `greatest`, with a message that says so.
CLI::Validator whole_number(std::int64_t least, std::int64_t greatest);
// The same of a time, from a millisecond to 10^9 seconds.
CLI::Validator seconds();

// Adds `--version` and the commands `help` and `completion`. Call it after all commands of the program are added.
void add_common(CLI::App& app);

// Reads the command line. Returns the exit code if the program is to end here: after help, a version, a manual page or
// completion, which are printed, or after a usage error, which is reported on standard error.
std::optional<int> parse(CLI::App& app, int argc, const char* const* argv, const Choices& choices = {}, const Elsewhere& elsewhere = {});

// The manual page of a program, in roff.
std::string manual_page(const CLI::App& app);

// The completion script of a program for "bash", "zsh" or "fish".
std::string completion(const CLI::App& app, const std::string& shell, const Choices& choices);

}  // namespace meld::cli
