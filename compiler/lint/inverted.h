// A least or greatest value that a recursion turns into its opposite: a better one makes itself worse.
#pragma once

#include <optional>

#include "compiler/check/program/program.h"

namespace meld::lint {

struct Inverted {
    check::PredicateId predicate;
    source::Span read;  // Where a rule reads it,
    source::Span made;  // and what the rule derives from it, which is worse the better the first is.
};

// lit(A, ~X) :- neighbor(A, B), lit(B, X), with `or`: true at B removes what makes A true, and A does the same to B. This includes cycles
// through other values of the stratum, if an odd number of steps inverts; and lit(A, true) :- neighbor(A, B), lit(B, false).
std::optional<Inverted> inverts_itself(const check::Program& program, const check::Stratum& stratum);

}  // namespace meld::lint
