// What a linear rule changes at its catom, as dirty bits: by them a catom knows which rules to try again after it has fired.
#pragma once

#include <cstdint>
#include <optional>

#include "compiler/emit/writer.h"

namespace meld::emit {

struct Marks {
    std::uint64_t made = 0, consumed = 0;
};

// If they are the same whenever the rule fires.
std::optional<Marks> marks_of(const plan::Plan& plan, const RulePlan& rule);

// Whether they are for all linear rules, and there are no views: then which rules to try again is known beforehand, and no bits are kept
// while a catom is evaluated.
bool fixed_marks(const plan::Plan& plan);

// Whether `rule` is to be tried again after these changes.
bool wakes(const Marks& marks, const RulePlan& rule);

}  // namespace meld::emit
