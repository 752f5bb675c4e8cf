// Of a min, max or the like: the values that its group would have if it were not for the one that it has.
#pragma once

#include <string>
#include <vector>

#include "runtime/ask/why/explainer.h"

namespace meld::inspect {

// Some of them, each with the rule and the body that derive it; how many more there are is the last line.
Result<std::vector<std::string>> runners_up(Explainer& explainer, const Known& fact);

}  // namespace meld::inspect
