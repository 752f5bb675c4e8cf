// Why a fact holds: the rule and the facts that it rests on, and those they rest on, down to what was given and sensed.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/ask/query/witness.h"
#include "runtime/ask/why/explanation.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::inspect {

// Facts are followed so many steps, if nothing else is said.
constexpr std::size_t kWhyDepth = 12, kWhyNotDepth = 4;

struct WhyOptions {
    std::size_t depth = kWhyDepth;  // 0: to the end.
    bool all = false;               // All facts that match, and all ways in which each of them holds; otherwise the first.
    bool origins = true;            // What made linear facts is looked for, by making the run again.
    std::size_t most_ways = 10;     // Of an aggregate; the others are counted. All of them with `all`.
};

// Why a fact, or the facts that match one with _ or variables, hold at the timeline's tick. No provenance is stored: derivations are found
// again in that state. A fact in recursion rests on facts of lower rank only, so the answer is finite and true. Where facts have changed
// since they were read, they are looked up in the states of earlier ticks, which is said of them. On process 0; every process calls it.
// Nothing is explained if no fact matches. Errors: mistakes in `fact`; a state that cannot be made again; a signal has asked for the end.
// Cost: that of the program's front end, and of the facts that are followed; each earlier tick is a run to it.
Result<Explanation> why(timeline::Timeline& timeline, const std::string& fact, const WhyOptions& options);

// The same of all facts of a body that holds, which are the parts of the only root.
Result<Explanation> why_body(timeline::Timeline& timeline, const Witness& witness, const WhyOptions& options);

// Why a fact does not hold: for each rule that could give it, how far its body can be satisfied and the part that then fails; where this is
// a fact that is not there, the same of that one. Errors and cost: as of why(); the fact's catom is not said.
Result<Explanation> why_not(timeline::Timeline& timeline, const std::string& fact, const WhyOptions& options);

// The same of a body that holds nowhere: the parts of it that hold together, and the one that then fails. Nothing is explained if it holds.
Result<Explanation> why_not_body(timeline::Timeline& timeline, const std::string& body, const WhyOptions& options);

}  // namespace meld::inspect
