// Recognizes the form of forall p [q] after its names are resolved.
#pragma once

#include "compiler/check/program/program.h"

namespace meld::check {

// Whether the clause is not (p, not (q)), where the two negations stand for a `forall`.
bool is_forall(const Clause& clause);

}  // namespace meld::check
