// The guarantees of the check for a program without mistakes.
#pragma once

#include "compiler/check/program/program.h"

namespace meld::check {

// Ends the process if a later stage could not rely on the program: a name without meaning, an operator without its operands, a rule without
// an execution site, a stratum that reads a later one. Such a program is our bug. Assumes that check() has reported no error. Cost: linear
// in the program.
void expect_well_formed(const Program& program);
// The same of one rule, also of one that the planner has made or changed.
void expect_well_formed(const Program& program, const Rule& rule);

}  // namespace meld::check
