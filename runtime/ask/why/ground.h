// A fact that somebody writes, with the values of its arguments.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::inspect {

struct Ground {
    std::string text = {};  // token(@3, 7)
    std::string predicate = {};
    std::uint64_t catom = 0;
    std::vector<std::string> arguments = {};  // After the catom; literals.
};

// What `fact` says, which need not hold; expressions without variables are computed. The same on every process. Errors: mistakes, with
// their places; it is no fact, or leaves something open.
Result<Ground> read_ground(sim::Subdomain& subdomain, const std::string& fact);

}  // namespace meld::inspect
