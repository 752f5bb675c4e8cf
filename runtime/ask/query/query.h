// Answers a body that is asked about a run: dist(A, D), D > 9, not leaf(A).
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "runtime/ask/query/table.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::inspect {

// All ways to satisfy the body in the present state of the run; on process 0, an empty table on the others. Every process calls it. Errors:
// mistakes in the body; it asks for what the run does not have; a signal has asked for the end.
// `looked` is called now and then with the number of facts that were looked at.
// Cost: that of the program's front end, and of the facts that the body makes it look at.
Result<Table> query(sim::Subdomain& subdomain, const std::string& body, const std::function<void(std::uint64_t)>& looked = {});

}  // namespace meld::inspect
