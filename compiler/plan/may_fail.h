// Whether what is computed may have no value: an expression overflows, divides by zero, or asks for what is not there.
//
// In a view such a derivation counts as absent (docs/design.md, "Undefined derivations").
#pragma once

#include "compiler/plan/plan.h"

namespace meld::plan {

// An expression, some of them, steps, a rule, the views that are evaluated together, and all views.
bool may_fail(const check::Program& program, const Term& t);
bool may_fail(const check::Program& program, const std::vector<Term>& terms);
bool may_fail(const check::Program& program, const std::vector<Step>& steps);
bool may_fail(const check::Program& program, const RulePlan& rule);
bool may_fail(const check::Program& program, const StratumPlan& stratum);
bool may_fail(const Plan& plan);

// Whether what an aggregate makes of the values of a group may have none.
bool fold_may_fail(const check::Predicate& p);

// Whether the rule fails for the same facts in whatever order its body is read. It does where all facts have been read before
// anything fails, and nothing that does not depend on it is tested afterwards.
bool fails_in_any_order(const check::Program& program, const RulePlan& rule);

}  // namespace meld::plan
