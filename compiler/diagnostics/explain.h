// The pages of `meldc explain`: what a kind of diagnostic means, with an example and its cure.
#pragma once

#include <string>

#include "compiler/diagnostics/diagnostics.h"

namespace meld::diagnostics {

// The page of one kind: its code and title, its meaning, a program that has the mistake, and one that does not. Ends with a new line.
std::string explanation(Kind kind);

}  // namespace meld::diagnostics
