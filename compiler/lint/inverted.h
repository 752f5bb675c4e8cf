// A least or greatest value that a recursion turns into its opposite: a better one makes itself worse.
#pragma once

#include <optional>

#include "compiler/check/program.h"

namespace meld::lint {

struct Inverted {
    check::PredicateId predicate;
    source::Span read;  // Where a rule reads it,
    source::Span made;  // and what the rule makes of it, which is worse the better that is.
};

// lit(A, ~X) :- neighbor(A, B), lit(B, X), with `or`: true at B takes away what makes A true, and A does the same to B. Also by way of
// other values of the stratum, where an odd number of them turns; and lit(A, true) :- neighbor(A, B), lit(B, false).
std::optional<Inverted> inverts_itself(const check::Program& program, const check::Stratum& stratum);

}  // namespace meld::lint
