// Recursion that counts rounds: every turn of it makes a number greater, so it ends where that number is bounded.
#pragma once

#include "compiler/check/program.h"

namespace meld::lint {

using check::Program;
using check::Stratum;

enum class Rounds { None, Bounded, Endless };

// Whether the first int of each group of the stratum is the number of a round: no rule makes it less than in what it reads of
// the stratum, and no cycle of rules leaves it as it is. Bounded: some rule compares it.
Rounds count_rounds(const Program& program, const check::Stratum& stratum);

}  // namespace meld::lint
