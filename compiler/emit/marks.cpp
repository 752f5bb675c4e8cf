#include "compiler/emit/marks.h"

#include <algorithm>

#include "compiler/plan/heads.h"

namespace meld::emit {

namespace {

using plan::as;
using plan::HeadPlan;
using plan::MakeFact;

bool consumes(const plan::Plan& plan, const plan::Step& step) {
    const auto* match = as<plan::Match>(step);
    return match != nullptr && plan.program.predicates[match->predicate].linear() && !match->read_only;
}

bool made_here(const plan::Plan& plan, const RulePlan& rule, const MakeFact& head) {
    return head.place == plan.program.rules[rule.rule].site && plan.program.predicates[head.predicate].kind != check::PredicateKind::Action;
}

// Whether heads that are made any number of times change nothing at the catom itself.
bool only_elsewhere(const plan::Plan& plan, const RulePlan& rule, const std::vector<HeadPlan>& heads) {
    bool only = true;
    plan::each_head_plan(heads, [&](const HeadPlan& h) {
        if (const auto* fact = as<MakeFact>(h)) only = only && !made_here(plan, rule, *fact);
        if (const auto* steps = plan::steps_of(h))
            only = only && std::ranges::none_of(*steps, [&](const auto& s) { return consumes(plan, s); });
    });
    return only;
}

}  // namespace

std::optional<Marks> marks_of(const plan::Plan& plan, const RulePlan& rule) {
    Marks marks;
    for (const plan::Step& s : rule.steps)
        if (consumes(plan, s)) marks.consumed |= plan.column_of(as<plan::Match>(s)->predicate).own_dirty;
    for (const HeadPlan& h : rule.heads) {
        const auto* fact = as<MakeFact>(h);
        if (fact == nullptr) {
            if (!only_elsewhere(plan, rule, {h})) return std::nullopt;
        } else if (made_here(plan, rule, *fact)) {
            // A persistent fact may be there already.
            if (!plan.program.predicates[fact->predicate].linear()) return std::nullopt;
            marks.made |= plan.column_of(fact->predicate).own_dirty;
        }
    }
    return marks;
}

bool fixed_marks(const plan::Plan& plan) {
    return plan.strata.empty() && std::ranges::all_of(plan.linear_rules, [&](const RulePlan& r) { return marks_of(plan, r).has_value(); });
}

bool wakes(const Marks& marks, const RulePlan& rule) { return (marks.made & rule.inputs) != 0 || (marks.consumed & rule.absent) != 0; }

}  // namespace meld::emit
