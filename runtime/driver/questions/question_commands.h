// The command lines of the commands that ask one thing about a run.
#pragma once

#include <string>

#include "runtime/driver/setup/options.h"

namespace CLI {
class App;
}

namespace meld::driver {

struct Asking {
    RunOptions run = {};
    std::string scratch = {};
    const CLI::App* command = nullptr;
};

void add_query(CLI::App& app, Asking& asking);
void add_facts(CLI::App& app, Asking& asking);
// name: why or why-not.
void add_why(CLI::App& app, Asking& asking, const std::string& name);
void add_history(CLI::App& app, Asking& asking);
void add_messages(CLI::App& app, Asking& asking);
void add_depends(CLI::App& app, Asking& asking);
// The options that all of them share: in which world the target runs, on how many processes, and how the answer is printed.
void add_target_options(CLI::App& command, Asking& asking);

}  // namespace meld::driver
