// A body whose ways at a catom depend on what that catom holds, on where it stands and on its links: dist(A, D), D > 3. Whoever keeps what
// it says of each catom asks again only where something has changed (Subdomain::follow()).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/ask/facts/program.h"
#include "runtime/ask/query/table.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::inspect {

class CatomQuestion {
  public:
    // Nothing: the body has a mistake, or may say something else of a catom although nothing has changed there. The same on every process.
    // Cost: that of the program's front end.
    static std::optional<CatomQuestion> read(const ModuleInfo& module, const std::string& body);

    // The variables that have values, as those of the tables below. The first that is a catom is the one that the body is about.
    std::vector<Table::Column> columns() const;

    // All ways at the catoms of this process, which asks no others; the state of the run does not change meanwhile. Errors: a signal has
    // asked for the end. Cost: a look at all facts of the first atom.
    Result<Table> at_all(sim::Subdomain& subdomain) const;
    // The same at these catoms, by their numbers. Cost: a search from each.
    Result<Table> at(sim::Subdomain& subdomain, std::span<const u64> catoms) const;

  private:
    CatomQuestion(Program program, check::VariableId catom) : program_(std::move(program)), catom_(catom) {}

    Program program_;
    check::VariableId catom_;
};

}  // namespace meld::inspect
