// The facts that a run has, read from its columns.
#pragma once

#include <string>
#include <vector>

#include "runtime/sim/core/subdomain.h"
#include "tests/reference/evaluator/value.h"

namespace meld::reference {

// Of predicates that users see.
struct Found {
    Facts facts;
    std::vector<Bag> linear;
};

// Those of this process. `suffix`: of what the compiler has made beside the predicates, under their names with this behind them.
Found collect(sim::Subdomain& subdomain, const check::Program& program, const std::string& suffix = "");

}  // namespace meld::reference
