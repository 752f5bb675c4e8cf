// What became of forall p [q] when its names were resolved.
#pragma once

#include "compiler/check/program.h"

namespace meld::check {

// Whether the clause is not (p, not (q)), where both negations stand for the whole of a `forall`.
bool is_forall(const Clause& clause);

}  // namespace meld::check
