// What may happen at a catom between two firings of one linear rule.
#pragma once

#include <cstdint>
#include <string>

#include "compiler/plan/plan.h"

namespace meld::plan {

// Why something else may happen, if the rule of this number makes and consumes facts with these dirty bits: a view depends on what it
// makes, or a rule before it may fire. Empty: nothing can.
inline std::string in_between(const Plan& plan, std::size_t number, std::uint64_t made, std::uint64_t consumed) {
    for (const StratumPlan& s : plan.strata)
        if ((s.inputs & made) != 0 && !s.predicates.empty())
            return fmt::format("{} depends on what it makes", plan.program.predicates[s.predicates[0]].name);
    for (std::size_t i = 0; i < number; ++i) {
        const RulePlan& earlier = plan.linear_rules[i];
        if ((earlier.inputs & made) != 0 || (earlier.absent & consumed) != 0)
            return fmt::format("{}, which is before it, may fire in between", plan.program.rules[earlier.rule].name);
    }
    return "";
}

}  // namespace meld::plan
