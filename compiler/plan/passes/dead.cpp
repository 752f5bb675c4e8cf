// Pass: dead rules. A view that can never fire, because one of its tests is false, is dropped if other rules derive the same predicate; all
// user predicates stay, because the facts that hold are the result of a run. Assumes folded constants.
#include <algorithm>

#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

bool never_fires(const Rule& rule) {
    return std::any_of(rule.body.begin(), rule.body.end(),
                       [](const Clause& c) { return c.kind == Clause::Kind::Test && c.test.op == Op::Bool && c.test.integer == 0; });
}

}  // namespace

void drop_dead_rules(check::Program& program) {
    // The world cannot give facts that rules derive: that must not change when the last rule is dropped.
    std::vector<bool> derived(program.predicates.count(), false);
    for (const Rule& rule : program.rules)
        if (!rule.linear && !never_fires(rule) && !rule.body.empty()) derived[rule.heads[0].atom.predicate.index()] = true;
    Table<Rule> kept;
    for (Rule& rule : program.rules)
        if (rule.linear || !never_fires(rule) || !derived[rule.heads[0].atom.predicate.index()]) kept.add(std::move(rule));
    program.rules = std::move(kept);
}

}  // namespace meld::plan
