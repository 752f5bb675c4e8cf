// Whether rules may derive ever more facts. A recursion that only passes on the values it finds comes to an end; one that computes new
// ones, as p(A, N + 1) :- p(A, N) does, may not, so runs have lower limits for it.
#include <algorithm>

#include "compiler/plan/join/draws.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

// A variable or a literal: no new value.
bool is_value(const Program& program, const Term& t) { return t.operands.empty() && !draws(program, t); }

// Whether the rule derives a group from what it computes.
bool computes(const Plan& plan, const RulePlan& r, Variables computed) {
    each_step(r.steps, [&](const Step& step) {
        const Set* set = as<Set>(step);
        if (set != nullptr && (!is_value(plan.program, set->value) || (set->value.is_variable() && computed.contains(set->value.variable))))
            computed.insert(set->variable);
        if (const AggregateOver* over = as<AggregateOver>(step)) computed.insert(over->variable);
    });
    for (const RulePlan& b : r.branches)
        if (computes(plan, b, computed)) return true;
    for (const HeadPlan& h : r.heads) {
        const MakeFact* fact = as<MakeFact>(h);
        if (fact == nullptr) return true;
        for (std::size_t i = 0; i < group_arguments(plan.program.predicates[fact->predicate]); ++i) {
            const Term& t = fact->arguments[i];
            if (!is_value(plan.program, t) || (t.is_variable() && computed.contains(t.variable))) return true;
        }
    }
    return false;
}

}  // namespace

bool may_grow(const Plan& plan, const StratumPlan& stratum) {
    return stratum.recursion != Recursion::None &&
           std::ranges::any_of(stratum.rules, [&](const RulePlan& r) { return computes(plan, r, {}); });
}

bool may_grow(const Plan& plan, PredicateId predicate) {
    return std::ranges::any_of(plan.strata, [&](const StratumPlan& s) {
        return std::ranges::find(s.predicates, predicate) != s.predicates.end() && may_grow(plan, s);
    });
}

}  // namespace meld::plan
