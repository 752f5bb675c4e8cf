// How the facts of a predicate are written, for messages to those who wrote its name alone.
#pragma once

#include <string>

#include "compiler/check/program/program.h"

namespace meld::check {

// "`dist` is a predicate; write a fact of it, as `dist(A, D)`", with the names of the declaration. Empty if no predicate of the program has
// this name; of several, that with the fewest arguments.
std::string fact_form_help(const Program& program, const std::string& name);

}  // namespace meld::check
