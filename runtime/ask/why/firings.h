// How linear rules may have fired in a tick: found again by the facts that there were before it, since nothing of it is stored.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/ask/why/explainer.h"

namespace meld::inspect {

struct Firings {
    // The first few, each with the catom at which the rule fired, and the facts of its body as parts. If there are none, but only one rule
    // can do it, that rule without parts, and without the catom if it may have been another one.
    std::vector<Explanation::Way> ways = {};
    std::size_t count = 0;   // Of all that were found.
    std::string rules = {};  // Those that can do it, each as FILE:LINE, with commas between.
};

// By which a fact was made in the tick of the explainer's first state; or taken, if it was there in the second, that of the tick before.
// Facts are looked up as they were before the tick, or, if nothing is found so, persistent and sensed ones as they are after it. What came
// and went within the tick is in neither, so firings that need it are not found; but for what is sensed as linear facts, if only one rule
// can have fired. Errors: those of a search.
Result<Firings> that_made(Explainer& explainer, const Known& fact);
Result<Firings> that_took(Explainer& explainer, const Known& fact);

}  // namespace meld::inspect
