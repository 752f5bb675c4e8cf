// `meldsim profile`: what a run's profile says, as tables, JSON, or a trace for a viewer.
#pragma once

#include <string>

namespace meld::driver {

struct ProfileOptions {
    std::string file = {};
    std::string trace = {};  // Where to write trace events; empty: nowhere.
    bool json = false;
};

// Returns the exit code.
int profile_command(const ProfileOptions& options);

}  // namespace meld::driver
