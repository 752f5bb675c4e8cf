// Pass: births. Finds whether the first evaluation of a catom does nothing where no fact holds at the catom and its neighbours export none:
// if every rule reads a stored fact before it computes, tests or counts anything. In
//     dist(A, 0) :- source(A).      dist(B, D + 1) :- neighbor(A, B), dist(A, D).
// only catoms that were given `source` have something to do in the first tick. When a run begins, the others are not evaluated. A rule
// such as `alone(A) :- not neighbor(A, _)` or a fact of the text keeps all births. Assumes steps in their final order.
#include <algorithm>

#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

bool is_plain(const Term& t) { return t.op == Op::Anonymous || t.op == Op::Variable || t.op == Op::Int; }

// Whether the rule does nothing unless some stored fact holds: nothing before that fact is read can fail or hold without it.
bool needs_fact(const Plan& plan, const std::vector<Step>& steps) {
    for (const Step& step : steps) {
        if (const Match* match = as<Match>(step)) {
            if (plan.of(match->predicate).column.valid()) return true;
            if (!std::ranges::all_of(match->arguments, is_plain)) return false;
        } else if (const EachNeighbour* each = as<EachNeighbour>(step)) {
            if (!is_plain(each->only) || !is_plain(each->port.equals)) return false;
        } else if (const Unless* unless = as<Unless>(step)) {
            if (!needs_fact(plan, unless->steps)) return false;
        } else if (const FindNeighbour* find = as<FindNeighbour>(step); find == nullptr || !is_plain(find->port.equals)) {
            return false;
        }
    }
    return false;
}

}  // namespace

void find_idle_births(Plan& plan) {
    const auto needs = [&](const RulePlan& rule) { return needs_fact(plan, rule.steps); };
    const auto idle = [&](const StratumPlan& stratum) {
        return stratum.recursion != Recursion::Rounds && std::ranges::all_of(stratum.rules, needs);
    };
    plan.idle_births = plan.initial_facts.empty() && !plan.reads_tick && std::ranges::all_of(plan.strata, idle) &&
                       std::ranges::all_of(plan.linear_rules, needs);
}

}  // namespace meld::plan
