// Makes a failing trial small: rules, clauses, heads, declarations, bursts, changes and catoms go as long as it still fails.
#pragma once

#include <functional>

#include "tests/reference/programs/draft.h"

namespace meld::reference {

// fails: whether a trial still shows the same trouble. Attempts are limited.
Trial shrink(Trial trial, const std::function<bool(const Trial&)>& fails, int attempts);

}  // namespace meld::reference
