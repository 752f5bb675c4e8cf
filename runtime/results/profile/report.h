// What a run did, as JSON, and as tables of that JSON: the same for the run that has just ended and for a profile in a file.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "runtime/module/abi/module_abi.h"
#include "runtime/results/profile/statistics.h"

namespace meld::profile {

nlohmann::ordered_json to_json(const ModuleInfo& module, const Gathered& all);

// Sections of lines for a terminal; of rules, catoms and ticks the busiest.
std::string tables(const nlohmann::ordered_json& statistics);

}  // namespace meld::profile
