// Pass: pull. A linear fact that catoms tell all their neighbours alike,
//     { B | neighbor(A, B) | told(B, R, T) }
// may stay where the sender writes it until its neighbours read it, one tick later, while nobody looks at facts in between
// (runtime/engine/eval/broadcasts.h). On lattices, where who is a neighbour of whom follows from places and is the same from both sides.
// Lists would have to be copied, and a predicate of which a catom holds one fact in a variable is no message. Runs after the letters.
#include <algorithm>

#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

bool may_be_pulled(const Plan& plan, PredicateId id) {
    const Predicate& p = plan.program.predicates[id];
    const Stored& stored = plan.of(id);
    if (!p.linear() || stored.storage != Storage::Rows || p.begins || p.finds_its_way) return false;
    if (std::ranges::any_of(p.arguments, [](const Argument& a) { return a.type.compound(); })) return false;
    return std::ranges::find(plan.singles.facts, id) == plan.singles.facts.end();
}

}  // namespace

void find_pulled(Plan& plan) {
    if (plan.program.by_links || plan.counts) return;
    for (const RulePlan& r : plan.linear_rules)
        each_head_plan(r.heads, [&](const HeadPlan& h) {
            const ForAll* all = as<ForAll>(h);
            const MakeFact* fact = all == nullptr ? nullptr : to_all_neighbours(*all);
            if (fact == nullptr || !may_be_pulled(plan, fact->predicate)) return;
            if (std::ranges::find(plan.pulled, fact->predicate) == plan.pulled.end()) plan.pulled.push_back(fact->predicate);
        });
}

}  // namespace meld::plan
