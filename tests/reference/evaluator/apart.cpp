#include "tests/reference/evaluator/apart.h"

namespace meld::reference {

using check::Clause;
using check::Op;
using check::Rule;
using check::Term;
using check::VariableId;

Rule told_apart(const Rule& rule) {
    Rule named = rule;
    for (Clause& c : named.body) {
        if (c.kind == Clause::Kind::Element) c.position = named.variables.add({"_", c.span, check::Type::Int});
        if (c.kind != Clause::Kind::Atom && c.kind != Clause::Kind::Delta) continue;
        for (Term& t : c.atom.arguments) {
            if (t.op != Op::Anonymous) continue;
            t.op = Op::Variable;
            t.variable = named.variables.add({"_", t.span, t.type});
        }
    }
    return named;
}

Apart::Apart(const check::Program& program, const HeadOf& head) : rule_(told_apart(*head.rule)), head_(head) {
    Clauses& body = rule_.body;
    Clauses same;
    for (Clause& c : body) {
        if (c.kind == Clause::Kind::Element) known_by_.push_back(c.position);
        if (c.kind != Clause::Kind::Atom) continue;
        for (Term& t : c.atom.arguments) {
            if (!t.is_variable()) {
                Term variable{.op = Op::Variable, .type = t.type, .span = t.span};
                variable.variable = rule_.variables.add({"_", t.span, t.type});
                Clause& is = same.emplace_back(Clause{.kind = Clause::Kind::Test});
                is.test = {.op = Op::Equal, .type = check::Type::Bool};
                is.test.operands = {variable, t};
                t = variable;
            }
            known_by_.push_back(t.variable);
        }
    }
    body.insert(body.end(), same.begin(), same.end());
    head_.rule = &rule_;
    head_.clauses = body;
    const check::Atom& made = head.head->atom;
    const check::Predicate& p = program.predicates[made.predicate];
    for (std::size_t a = 0; a < made.arguments.size(); ++a)
        // What is counted is not computed.
        if (p.aggregate != check::Aggregate::Count || a != p.aggregate_at)
            check::each_variable(made.arguments[a], [&](VariableId v) { known_by_.push_back(v); });
}

Environment Apart::known(const Environment& env) const {
    Environment out(env.size());
    for (const VariableId v : known_by_) out[v.index()] = env[v.index()];
    return out;
}

}  // namespace meld::reference
