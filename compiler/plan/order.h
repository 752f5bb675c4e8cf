// What other passes ask of the join order.
#pragma once

#include "compiler/plan/plan.h"

namespace meld::plan {

// The steps that lead from changed rows of the body's clause `first`, an atom, to the variables of the head's group. The body
// is the rule's in other words, in which no argument of the atom is computed of variables.
std::vector<Step> order_changed(const Plan& plan, const check::Rule& rule, const std::vector<check::Clause>& body, std::size_t first,
                                const std::vector<VariableId>& needed);
// All steps of such a body with changed rows of the clause `first` read before anything else.
RulePlan order_fresh(const Plan& plan, RuleId rule, std::vector<check::Clause> body, std::size_t first);
// The rule, in other words, where some variables are known from the start.
RulePlan order_group(const Plan& plan, RuleId rule, const ComponentPlan& component, const std::vector<check::Clause>& body,
                     const std::vector<VariableId>& given);
// Those after which an aggregate may wait for other neighbours; 0 where it waits for none.
std::uint64_t waiting_inputs(const Plan& plan, PredicateId predicate);
// The dirty bits after which these steps may have another outcome.
std::uint64_t inputs_of(const Plan& plan, const std::vector<Step>& steps);

}  // namespace meld::plan
