// A run as the words of a command that makes it again.
#pragma once

#include <string>
#include <vector>

#include "runtime/driver/setup/options.h"

namespace meld::driver {

// `meldsim run` with all options that decide about the state in each tick, with the number of threads and the limits of the run, and with
// what it is watched for; without outputs, and on one process. Paths, which begin in the folder `base` (empty: where this process is), are
// as seen from the folder `from`.
std::vector<std::string> run_words(const RunOptions& run, const std::string& from, const std::string& base = "");

}  // namespace meld::driver
