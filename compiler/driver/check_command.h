// `meldc check`: the mistakes of one or more programs, and the fixes that need no thought.
#pragma once

#include <string>
#include <vector>

#include "compiler/driver/compile.h"
#include "compiler/driver/show_messages.h"

namespace meld::driver {

struct CheckOptions {
    std::vector<std::string> files = {};
    bool json = false;
    HowMany how_many = HowMany::MostSevere;
    // Applies the safe fixes first (diagnostics/fix.h); the messages are those that remain.
    bool fix = false;
    CompileOptions compile = {};
};

// Returns the exit code, the worst of all programs. A message about a file that several programs include is shown once.
int run_check(const CheckOptions& options);

}  // namespace meld::driver
