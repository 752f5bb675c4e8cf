// Facts of a whole run, gathered for somebody who asks. Every process calls all of this at the same time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/ask/debug/answer.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::debug {

// On every process: whether any has this catom.
bool catom_exists(sim::Subdomain& subdomain, std::uint64_t id);

struct WhichFacts {
    std::optional<std::uint64_t> catom = {};
    std::string name = {};         // Of a predicate or its table; empty: all.
    std::uint64_t most_lines = 0;  // Beyond these, facts are only counted.
};

// On process 0 all of it, on the others only the tick. Errors: there is no such catom or predicate. Cost: a look at all catoms for each
// table; the lines pass through process 0.
Result<FactsFound> find_facts(sim::Subdomain& subdomain, const WhichFacts& which);

// What came and what went from one state of a run to another: by predicate, the same on every process, and the facts themselves, on process
// 0, by predicate and in natural order; those that went are the first of `most_lines`. Cost: as of find_changes().
struct ChangedFacts {
    std::vector<Changes::Predicate> predicates = {};
    std::vector<std::string> come = {}, gone = {};
};
ChangedFacts find_changed_facts(sim::Subdomain& before, sim::Subdomain& now, std::uint64_t most_lines);

// What came and what went from one state of a run to another, by predicate; the same on every process. Cost: the facts of one table at a
// time, of both states, as text, divided among the processes.
std::vector<Changes::Predicate> find_changes(sim::Subdomain& before, sim::Subdomain& now);

}  // namespace meld::debug
