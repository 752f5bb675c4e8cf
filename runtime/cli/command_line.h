// What the command lines of all programs share: `help`, `--version`, the nearest name for a mistyped command or option, manual
// pages and completion, all made from the program's table of commands and options.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace meld::cli {

// The words that an option or a command's argument may be, for completion: "--emit" or "explain" to its words.
using Choices = std::map<std::string, std::vector<std::string>>;

// Adds `--version` and the commands `help` and `completion`. Call it after all commands of the program are added.
void add_common(CLI::App& app);

// Reads the command line. Returns the exit code if the program is to end here: after help, a version, a manual page or
// completion, which are printed, or after a usage error, which is reported on standard error.
std::optional<int> parse(CLI::App& app, int argc, const char* const* argv, const Choices& choices = {});

// The manual page of a program, in roff.
std::string manual_page(const CLI::App& app);

// The completion script of a program for "bash", "zsh" or "fish".
std::string completion(const CLI::App& app, const std::string& shell, const Choices& choices);

}  // namespace meld::cli
