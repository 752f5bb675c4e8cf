// Pass: given facts. Facts that linear rules, messages or the world give to a predicate that rules derive too, or that neighbours read, are
// stored in a separate auxiliary, for example p', with the rule p(A, X) :- p'(A, X). So every stored predicate is either given or derived,
// never both; and facts given in a tick reach the neighbours one tick later, by the same commit as all other changes, wherever they are.
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

void collect_given(const std::vector<Head>& heads, const Program& program, std::vector<bool>& given) {
    each_head(heads, [&](const Head& h) {
        if (h.kind == Head::Kind::Fact && program.predicates[h.atom.predicate].kind == PredicateKind::Persistent)
            given[h.atom.predicate.index()] = true;
    });
}

void redirect(std::vector<Head>& heads, PredicateId from, PredicateId to) {
    for (Head& h : heads) {
        if (h.kind == Head::Kind::Fact && h.atom.predicate == from) h.atom.predicate = to;
        redirect(h.heads, from, to);
        redirect(h.others, from, to);
    }
}

// Predicates that some rule reads at another catom than its execution site.
std::vector<bool> read_elsewhere(const Program& program) {
    std::vector<bool> out(program.predicates.count(), false);
    for (const Rule& rule : program.rules) {
        const auto read = [&](const Atom& a, bool) {
            if (a.arguments[0].variable != rule.site) out[a.predicate.index()] = true;
        };
        each_atom(rule.body, read);
        each_head(rule.heads, [&](const Head& h) { each_atom(h.body, read); });
    }
    return out;
}

}  // namespace

void separate_base(Program& program) {
    std::vector<bool> given(program.predicates.count(), false), derived(program.predicates.count(), false),
        by_rules(program.predicates.count(), false);
    for (const Rule& rule : program.rules) {
        if (rule.linear) {
            collect_given(rule.heads, program, given);
            continue;
        }
        const std::size_t head = rule.heads[0].atom.predicate.index();
        derived[head] = true;
        each_atom(rule.body, [&](const Atom&, bool) { by_rules[head] = true; });
    }
    // What the program gives by axioms alone, the world may add to.
    for (const PredicateId p : program.predicates.ids())
        if (derived[p.index()] && !by_rules[p.index()] && !program.predicates[p].auxiliary) given[p.index()] = true;
    const std::vector<bool> elsewhere = read_elsewhere(program);
    for (const PredicateId p : program.predicates.ids()) {
        const PredicateKind kind = program.predicates[p].kind;
        if ((kind != PredicateKind::Persistent && kind != PredicateKind::Sensed) || program.predicates[p].world != WorldSource::None)
            continue;
        // An aggregated predicate that nothing derives is given and then aggregated.
        const bool aggregated = program.predicates[p].aggregate != Aggregate::None && !program.predicates[p].sensed;
        const bool needs = derived[p.index()] ? given[p.index()] : aggregated || elsewhere[p.index()];
        if (!needs) continue;
        Predicate base = program.predicates[p];
        base.name = base.name + "'";
        if (!base.sensed) {
            base.aggregate = Aggregate::None;
            base.fold = {};
        }
        base.auxiliary = true;
        base.route = base.prelude = false;
        const PredicateId to = program.predicates.add(base);
        program.predicates[p].given = to;
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
        copy.site = head.atom.arguments[0].variable;
        copy.body = {body};
        copy.heads = {head};
        copy.text = print(program, copy);
        program.rules.add(std::move(copy));
    }
}

}  // namespace meld::plan
