// Pass: facts given to a derived predicate by linear rules live in an auxiliary of their own, p' say, with the rule
// p(A, X) :- p'(A, X). So every stored predicate is either given or derived, never both.
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

void collect_given(const std::vector<Head>& heads, const Program& program, std::vector<bool>& given) {
    for (const Head& h : heads) {
        if (h.kind == Head::Kind::Fact && program.predicates[h.atom.predicate].kind == PredicateKind::Persistent) given[h.atom.predicate.index()] = true;
        collect_given(h.heads, program, given);
    }
}

void redirect(std::vector<Head>& heads, PredicateId from, PredicateId to) {
    for (Head& h : heads) {
        if (h.kind == Head::Kind::Fact && h.atom.predicate == from) h.atom.predicate = to;
        redirect(h.heads, from, to);
    }
}

}  // namespace

void separate_base(Program& program) {
    std::vector<bool> given(program.predicates.count(), false), derived(program.predicates.count(), false);
    for (const Rule& rule : program.rules) {
        if (rule.linear) collect_given(rule.heads, program, given);
        else derived[rule.heads[0].atom.predicate.index()] = true;
    }
    for (const PredicateId p : program.predicates.ids()) {
        // An aggregated predicate that nothing derives is given and then aggregated.
        const bool aggregated = program.predicates[p].aggregate != Aggregate::None && !program.predicates[p].sensed;
        const bool needs = (derived[p.index()] && given[p.index()]) || (aggregated && !derived[p.index()] && program.predicates[p].kind == PredicateKind::Persistent);
        if (!needs) continue;
        Predicate base = program.predicates[p];
        base.name = base.name + "'";
        base.aggregate = Aggregate::None;
        base.auxiliary = true;
        base.route = false;
        const PredicateId to = program.predicates.add(base);
        for (Rule& rule : program.rules)
            if (rule.linear) redirect(rule.heads, p, to);
        Rule copy;
        copy.name = program.predicates[p].name + "@given";
        copy.span = base.span;
        Clause body{.kind = Clause::Kind::Atom, .span = base.span};
        body.atom.predicate = to;
        Head head{.kind = Head::Kind::Fact, .span = base.span};
        head.atom.predicate = p;
        for (std::size_t i = 0; i < base.arguments.size(); ++i) {
            Term v;
            v.op = Op::Variable;
            v.type = base.arguments[i].type;
            v.variable = copy.variables.add({i == 0 ? "A" : "X" + std::to_string(i), base.span, v.type});
            body.atom.arguments.push_back(v);
            head.atom.arguments.push_back(v);
        }
        copy.home = head.atom.arguments[0].variable;
        copy.body = {body};
        copy.heads = {head};
        copy.text = print(program, copy);
        program.rules.add(std::move(copy));
    }
}

}  // namespace meld::plan
