// Which recursive strata must keep more of a min or max than its best value.
#pragma once

#include <optional>

#include "compiler/check/program/program.h"

namespace meld::check {

// A better value may follow from one that it replaces, through a rule that asks only whether there is a value or whether it is within a
// bound, or through an expression that improves it. If the group then forgets its earlier value, the better value loses its support and the
// group starts again, for ever. The cure is to keep the front of each group: its derivations (value, rank) that no other one beats in both
// (runtime/module/kernel/fronts.h).
enum class Fronts {
    NotNeeded,   // No value of the stratum can follow from a worse one of its group, or only without end.
    Needed,      // It may, and all rules of the stratum are monotone: better values derive at least what worse ones do.
    Impossible,  // It may, but some rule is not monotone, so worse values would derive what the best one does not.
};

// For a recursive stratum that is not a tree (Stratum::tree).
Fronts fronts_of(const Program& program, const Stratum& stratum);

// A rule that asks only for the existence of a value, or for a bound, in a stratum where fronts are impossible and existence
// cannot be separated from the values (compiler/plan/passes/exists.cpp): the run may not quiesce.
struct NotMonotone {
    PredicateId asked;
    Span ask;     // The atom.
    Span breaks;  // The expression or clause that is not monotone.
};
std::optional<NotMonotone> not_monotone(const Program& program, const Stratum& stratum);

}  // namespace meld::check
