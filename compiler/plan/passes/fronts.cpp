// Pass: fronts. In a strongly connected component where a better value of a min or max may follow from the one that it replaces,
// the rules work on all derivations that no other beats, and the predicate itself is the best of them:
//     p(A, 5) :- b(A).      q(B) :- neighbor(A, B), p(A, _).      p(B, V + 1) :- neighbor(A, B), p(A, V), V < 9, q(B).
// becomes
//     p@front(A, 5) :- b(A).      q(B) :- neighbor(A, B), p@front(A, _).
//     p@front(B, V + 1) :- neighbor(A, B), p@front(A, V), V < 9, q(B).      p(A, V) :- p@front(A, V).
// A rule that tests for existence or a bound is supported by any derivation that satisfies it, including the oldest; a value computed from
// each is on the front of its head or beaten there. Assumes that existence is tested where that is enough (exists.cpp).
#include <algorithm>

#include "compiler/check/analysis/fronts.h"
#include "compiler/desugar/made.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

PredicateId front_of(Program& program, PredicateId p) {
    Predicate front = program.predicates[p];
    front.name += "@front";
    front.auxiliary = true;
    front.prelude = front.route = false;
    front.given = {};
    front.front = front.aggregate;
    front.aggregate = Aggregate::None;
    return program.predicates.add(std::move(front));
}

void keep_front(Program& program, PredicateId p, const std::vector<RuleId>& rules) {
    const PredicateId front = front_of(program, p);
    for (const RuleId id : rules) {
        Rule& rule = program.rules[id];
        if (rule.heads[0].atom.predicate == p) rule.heads[0].atom.predicate = front;
        for (Clause& c : rule.body)
            if (c.kind == Clause::Kind::Atom && c.atom.predicate == p) c.atom.predicate = front;
    }
    desugar::MadeRule best(program, front, program.predicates[p].name + "@best");
    best.head(program, p, 0);
    best.add_to(program);
}

}  // namespace

void keep_fronts(Program& program) {
    find_strongly_connected(program);
    const std::vector<check::Stratum> strata = program.strata;
    for (const check::Stratum& c : strata) {
        if (!c.recursive || c.tree || fronts_of(program, c) != Fronts::Needed) continue;
        for (const PredicateId p : c.predicates)
            if (program.predicates[p].aggregate != Aggregate::None) keep_front(program, p, c.rules);
    }
}

}  // namespace meld::plan
