// Recursion that counts rounds: every round increases a number, so it ends if that number is bounded.
#pragma once

#include "compiler/check/program.h"

namespace meld::lint {

using check::Program;
using check::Stratum;

enum class Rounds { None, Bounded, Endless };

// Whether the first int of each group of the stratum is the number of a round: no rule derives a smaller one than it reads from the
// stratum, and no cycle of rules leaves it unchanged. Bounded: some rule asks
// for a number below something.
Rounds count_rounds(const Program& program, const check::Stratum& stratum);

}  // namespace meld::lint
