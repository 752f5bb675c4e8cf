// Answers a body that is asked about a run: dist(A, D), D > 9, not leaf(A).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/ask/facts/facts.h"
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

// The variables of a body that has been read which have a value in every way to satisfy it.
std::vector<Table::Column> columns_of(const Program& program);

// The same for whoever has the facts: this process alone answers. With `from`, the ways in which a variable is one of these catoms.
struct From {
    check::VariableId start = {};
    std::span<const u64> catoms = {};
};
Result<Table> query_here(const sim::Subdomain& subdomain, Facts& facts, const Program& program, const std::optional<From>& from = {},
                         const std::function<void(std::uint64_t)>& looked = {});

}  // namespace meld::inspect
