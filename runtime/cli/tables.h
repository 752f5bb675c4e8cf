// The table of commands and options of a program in the form that manual pages and completion read.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace meld::cli {

struct OptionRow {
    std::string short_name, long_name;  // With their hyphens; either may be empty.
    std::string value;                  // The value that follows it, "FILE"; empty for a flag.
    std::string description;
};

struct CommandRow {
    std::string name;
    std::string arguments;  // "FILE...", or empty.
    std::string summary;    // A sentence.
    std::string example;    // A command line, or empty.
    std::vector<OptionRow> options;
};

// The commands that users see, in the order in which they were added.
std::vector<CommandRow> commands_of(const CLI::App& app);
std::vector<OptionRow> options_of(const CLI::App& app);

}  // namespace meld::cli
