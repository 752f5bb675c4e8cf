// A value of min or max that a rule reads, tests, and may replace by one that does not pass the test.
#pragma once

#include <optional>

#include "compiler/lint/replaced.h"

namespace meld::lint {

// v(A, Y) :- neighbor(A, B), v(A, X), v(B, Y), X > Y, with a min: as soon as Y has replaced X, nothing supports it. The rule may read the
// value of its head's group in other rules of the stratum, and derive the new one through them: such rules are put in the place of what
// they derive. Only if the new value is not certainly worse, and some test of the old one need not hold for a better one.
std::optional<Replaced> guarded_by_itself(const Program& program, const Stratum& stratum);

}  // namespace meld::lint
