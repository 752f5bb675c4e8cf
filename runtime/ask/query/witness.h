// A way in which a body holds.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "runtime/module/abi/geometry_abi.h"

namespace meld::inspect {

// With the catom of its first fact, and the values of its other variables, as Meld.
struct Witness {
    std::string body = {};
    u64 catom = 0;
    std::vector<std::pair<std::string, std::string>> values = {};
};

}  // namespace meld::inspect
