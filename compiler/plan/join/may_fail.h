// Whether a computation may have no value: an expression overflows, divides by zero, or asks for a missing element.
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

// Whether the aggregate of the values of a group may have no value.
bool fold_may_fail(const check::Predicate& p);

// Whether the rule fails for the same facts in whatever order its body is read. It does if all facts have been read before anything can
// fail, and nothing independent of the failure is tested afterwards.
bool fails_in_any_order(const check::Program& program, const RulePlan& rule);

}  // namespace meld::plan
