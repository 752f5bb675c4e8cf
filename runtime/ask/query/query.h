// Answers a body that is asked about a run: dist(A, D), D > 9, not leaf(A).
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "runtime/ask/facts/program.h"
#include "runtime/ask/query/table.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::inspect {

// All ways to satisfy the body in the present state of the run; on process 0, an empty table on the others. Every process calls it. Errors:
// mistakes in the body; it asks for what the run does not have; a signal has asked for the end.
// `looked` is called now and then with the number of facts that were looked at.
// Cost: that of the program's front end, and of the facts that the body makes it look at.
Result<Table> query(sim::Subdomain& subdomain, const std::string& body, const std::function<void(std::uint64_t)>& looked = {});

// The same of a body that has been read, for whoever asks it of many states or runs: the program's front end runs once. The module of the
// run is the one that it was read for.
Result<Program> read_question(const ModuleInfo& module, const std::string& body);
Result<Table> query(sim::Subdomain& subdomain, const Program& program, const std::function<void(std::uint64_t)>& looked = {});

}  // namespace meld::inspect
