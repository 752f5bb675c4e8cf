// The counts of a run that do not depend on the machine, by name.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string_view>
#include <vector>

#include "runtime/sim/simulation.h"

namespace meld::driver {

// The names, in the order of tables: those of `meldsim run --json`, `refused_actions` as one number, and `messages`: all that crossed a
// link.
const std::vector<std::string_view>& count_names();
// By name. The same for any number of processes and threads.
nlohmann::ordered_json counts_of(const sim::Summary& summary);

}  // namespace meld::driver
