// `meldsim diff`: what two results of runs differ in.
#pragma once

#include <string>

#include "runtime/driver/setup/options.h"

namespace meld::driver {

struct DiffOptions {
    std::string a, b;
    bool json = false;
};

// The exit code of two results that differ, as of diff(1).
inline constexpr int kDiffer = 1;

// Returns the exit code: 0 if they are the same, kDiffer, or that of an error.
int diff_command(const DiffOptions& options, const ParseRun& parse);

}  // namespace meld::driver
