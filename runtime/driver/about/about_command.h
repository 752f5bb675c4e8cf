// The command line of `meldsim about`.
#pragma once

#include <string>

#include "runtime/driver/setup/options.h"

namespace CLI {
class App;
}

namespace meld::driver {

struct AboutOptions {
    std::string run;  // A recording, a folder of checkpoints, or a study; STUDY#ROW is a row of it.
    std::string row = {}, folder = {};
    bool json = false, latex = false;
};

CLI::App* add_about(CLI::App& app, AboutOptions& about);

// Returns the exit code; prints its own messages.
int about_command(const AboutOptions& options, const ParseRun& parse);

}  // namespace meld::driver
