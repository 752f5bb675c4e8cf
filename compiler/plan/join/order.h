// The functions of the join order for other passes.
#pragma once

#include "compiler/plan/plan.h"

namespace meld::plan {

// The steps that lead from changed rows of the body's clause `first`, an atom, to the variables of the head's group. The body is that of
// the rule, rewritten so that no argument of the atom is a computed term.
std::vector<Step> order_changed(const Plan& plan, const check::Rule& rule, std::vector<check::Clause> body, std::size_t first,
                                const std::vector<VariableId>& needed);
// A semi-naive rule: all steps of such a body with changed rows of the clause `first` read before anything else. `growing`: the predicates
// of its stratum.
RulePlan order_semi_naive(const Plan& plan, RuleId rule, std::vector<check::Clause> body, std::size_t first,
                          const std::vector<PredicateId>& growing);
// The rewritten rule, where the variables of the head's group are known from the start.
RulePlan order_group(const Plan& plan, RuleId rule, const StratumPlan& stratum, const std::vector<check::Clause>& body,
                     const std::vector<VariableId>& given);

// The dirty bits after which these steps may have another result.
std::uint64_t inputs_of(const Plan& plan, const std::vector<Step>& steps);
std::uint64_t inputs_of(const Plan& plan, const std::vector<HeadPlan>& heads);
// The bits of linear facts whose removal may let the steps succeed: those inside negations and aggregates. Consuming any other fact does
// not enable a rule that could not fire.
std::uint64_t absent_inputs(const Plan& plan, const std::vector<Step>& steps);
// The bits after which an aggregate may wait for other neighbours; 0 if it waits for none.
std::uint64_t waiting_inputs(const Plan& plan, PredicateId predicate);

}  // namespace meld::plan
