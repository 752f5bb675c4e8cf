// Folds by a function of the program that only picks the least or the greatest value:
//     fun less(int A, int B) : int = if A < B then A else B end.
// In any order they give the same, so candidates need no order, and the function need not be called.
#pragma once

#include <optional>

#include "compiler/plan/plan.h"

namespace meld::plan {

// Min or Max, if this function picks the one of its two ints that is less or greater.
std::optional<check::Aggregate> picks(const check::Function& function);

// The same for the fold of a predicate whose candidates are all there when it is decided.
std::optional<check::Aggregate> picks(const Plan& plan, PredicateId id);

}  // namespace meld::plan
