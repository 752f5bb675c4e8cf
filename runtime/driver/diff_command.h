// `meldsim diff`: what two results of runs differ in.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/driver/options.h"

namespace meld::driver {

struct DiffOptions {
    std::string a, b;
    bool json = false;
};

// The exit code of two results that differ, as of diff(1).
inline constexpr int kDiffer = 1;

// Returns the exit code: 0 if they are the same, kDiffer, or that of an error. `parse` reads a command line of `meldsim run`, as a
// checkpoint has it; nothing if it is none.
int diff_command(const DiffOptions& options, const std::function<std::optional<RunOptions>(const std::vector<std::string>&)>& parse);

}  // namespace meld::driver
