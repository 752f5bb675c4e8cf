// Breaks on linear rules. What such a rule consumes is gone after the tick, and several rules may have made the same fact, so the run
// itself says which of them have fired, where, and with which values.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "compiler/check/program/program.h"
#include "runtime/base/error.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::debug {

struct LinearBreak {
    u32 rule = 0;                // Its number in the module,
    std::string place = {};      // and where it stands.
    std::string body = {};       // In Meld, for the types of its variables.
    std::string condition = {};  // In Meld, with these variables; empty: none.
};

// The break as the module knows the rule. Errors: mistakes in the condition; it asks for what the run does not have.
Result<LinearBreak> linear_break(const ModuleInfo& module, const check::Rule& rule, const std::string& condition);

// How a rule has fired in a tick; on process 0.
struct Fired {
    std::vector<u64> at = {};            // The catoms, ascending, and of each in the order of its firings,
    std::vector<std::string> ways = {};  // and with which values: A = @3, D = 7.
};

// Of each break, after a tick of a run that tells the firings of their rules (Subdomain::tell_firings()). A condition is searched in the
// state after the tick, with the values that the variables had. Every process calls it. Errors: those of a search; the condition needs a
// variable that the rule does not keep. Cost: the firings of these rules, and a search for each.
Result<std::vector<Fired>> fired(sim::Subdomain& subdomain, std::span<const LinearBreak> breaks);

}  // namespace meld::debug
