// Derivations by rules with a delay, for aggregates such as sum and count in which every derivation counts.
#pragma once

#include <optional>

#include "runtime/ask/why/explainer.h"

namespace meld::inspect {

// Makes the places of elements in lists known to a rule with a delay, by which delay_has_passed() knows its derivations again.
void tell_apart(PartialMatch& match);

// Whether the body of a rule, told apart, has been met in this way for as long as its head's delay says, by the end of the tick of
// `search`. A way is known again by the facts of the body, the places of elements in lists, and the head; what is computed beside these
// may change, as in a run (compiler/desugar/delay.cpp). Nothing: the states that there are do not tell. Errors: a signal
// has asked for the end. Cost: a search in each of these ticks.
Result<std::optional<bool>> delay_has_passed(Explainer& explainer, const PartialMatch& match, const Explainer::Search& search,
                                             const Solution& solution);

}  // namespace meld::inspect
