// Recursion in rounds: every cycle of rules increases a number, so a fact never depends on itself, whatever its rules ask of each other:
// negations, sums and counts included. It ends if that number is bounded.
#pragma once

#include "compiler/check/program/program.h"

namespace meld::check {

enum class Rounds { None, Endless, Bounded };

// Whether some int in the group of each predicate of the stratum is the number of a round: no rule derives a smaller one than it reads
// from the stratum, and no cycle of rules leaves it unchanged. Bounded: in each cycle some rule bounds the number that it reads, by a
// comparison with something that the stratum does not compute, or because a fact from outside has it. Assumes execution sites.
Rounds count_rounds(const Program& program, const Stratum& stratum);

}  // namespace meld::check
