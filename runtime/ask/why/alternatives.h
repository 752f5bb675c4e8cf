// The alternatives of an aggregate such as min: the values that a group would have without the one that won.
#pragma once

#include <string>
#include <vector>

#include "runtime/ask/why/explainer.h"

namespace meld::inspect {

// Some of them, each with the rule and the body that derive it; how many more there are is the last line.
Result<std::vector<std::string>> alternatives(Explainer& explainer, const Known& fact);

}  // namespace meld::inspect
