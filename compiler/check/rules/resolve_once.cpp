// Pass 2, linear facts of rules that consume nothing: each new way to satisfy the body makes one. The catom remembers for which ways it has
// done so, and forgets a way when the body no longer holds for it; if it holds again later, that is a new one.
//     !a(A, X) -o b(A, X).     b@due4(A, X) :- a(A, X).
//                              b@due4(A, X), not b@done4(A, X) -o b(A, X), b@done4(A, X).
//                              b@done4(A, X), not b@due4(A, X) -o 1.
// It is remembered at the catom of the head. In a graph that may be one to which no link of the body leads; then it is remembered where the
// first fact of the body is, and the head finds its way from there.
//     !a(A, B, X) -o b(B, X).  b@due4(A, B, X) :- a(A, B, X).
//                              b@due4(A, B, X), not b@done4(A, B, X) -o b(B, X), b@done4(A, B, X).
//
// A comprehension or aggregate in the head of such a rule may consume linear facts. It does so once for each way, too:
//     !a(A) -o {X | b(A, X) | c(A, X)}.
//                              c@due4(A) :- a(A).
//                              c@due4(A), not c@done4(A) -o {X | b(A, X) | c(A, X)}, c@done4(A).
//                              c@done4(A), not c@due4(A) -o 1.
//
// A view at such a node is made of these: its facts are sent, and stay.
//     q(B, X) :- a(A, B, X).   !a(A, B, X) -o q@sent5(B, X).     q@sent5(B, X) -o q(B, X).
#include <algorithm>

#include "compiler/check/rules/resolver.h"
#include "runtime/base/assert.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

// The variables that tell one way from another: all that the body binds. An argument that may be anything becomes one.
Variables name_ways(std::vector<Clause>& body, Rule& rule) {
    Variables ways;
    const auto add = [&](VariableId v) { ways.insert(v); };
    for (Clause& c : body) {
        if (c.kind == Clause::Kind::Not) continue;
        for (Term& argument : c.atom.arguments) {
            if (argument.op == Op::Anonymous) {
                argument.op = Op::Variable;
                argument.variable = rule.variables.add({"_", argument.span, argument.type});
            }
            each_variable(argument, add);
        }
        // What an aggregate or an element is computed from, other clauses bind, or it is local.
        if (c.kind == Clause::Kind::Test) each_free_use(c.test, [&](const Term& t) { add(t.variable); });
        if (c.variable.valid()) add(c.variable);
    }
    return ways;
}

// Where it is remembered what has been made at `goal`: there, if the links of the body join it to a fact of the body.
VariableId remembered_at(const Program& program, const std::vector<Clause>& body, VariableId goal) {
    Variables seen{goal};
    for (std::size_t before = 0; before != seen.size();) {
        before = seen.size();
        for (const Clause& c : body) {
            if (c.kind != Clause::Kind::Atom) continue;
            const std::vector<Term>& arguments = c.atom.arguments;
            const VariableId at = arguments[0].variable;
            if (!program.predicates[c.atom.predicate].route || arguments.size() < 2 || !arguments[1].is_variable()) continue;
            if (seen.contains(at) || seen.contains(arguments[1].variable)) seen.insert({at, arguments[1].variable});
        }
    }
    const auto read = [&](const Clause& c) { return c.kind == Clause::Kind::Atom && seen.contains(c.atom.arguments[0].variable); };
    const auto fact = std::ranges::find(body, Clause::Kind::Atom, &Clause::kind);
    return fact == body.end() || std::ranges::any_of(body, read) ? goal : fact->atom.arguments[0].variable;
}

}  // namespace

void Resolver::once(const Rule& rule, const std::vector<Clause>& body, const Head& head) {
    MELD_EXPECT(head.kind == Head::Kind::Fact && program_.predicates[head.atom.predicate].linear(), "rule {} makes no linear fact",
                rule.name);
    once(rule, body, head, head.atom.arguments[0], program_.predicates[head.atom.predicate].name);
}

bool Resolver::part_with_linear_facts(const Rule& rule, const std::vector<Clause>& body, const Head& head) {
    const Atom* consumed = nullptr;
    const Atom* read = nullptr;
    each_atom(head.body, [&](const Atom& a, bool negated) {
        if (!program_.predicates[a.predicate].linear()) return;
        (negated || a.read_only ? read : consumed) = &a;
    });
    if (consumed == nullptr && read == nullptr) return false;
    if (refused_ || report_.error_count() > errors_before_) return true;
    const std::string& name = program_.predicates[(consumed != nullptr ? consumed : read)->predicate].name;
    if (consumed == nullptr || tree_->arrow == syntax::Arrow::View) {
        report_
            .add(Kind::LinearInside, (consumed != nullptr ? consumed : read)->span,
                 fmt::format("`{}` is linear, and a view cannot depend on it", name))
            .help = consumed != nullptr ? "write the rule with -o, and it consumes the facts once for each new way to satisfy its body"
                                        : "consume a linear fact in the body";
        return true;
    }
    // Where the facts are, unless only the part knows.
    const Term* goal = &consumed->arguments[0];
    bool known = false;
    for (const Clause& c : body) each_variable(c, [&](VariableId v) { known = known || v == goal->variable; });
    const auto fact = std::ranges::find(body, Clause::Kind::Atom, &Clause::kind);
    if (!known && fact != body.end()) goal = &fact->atom.arguments[0];
    once(rule, body, head, *goal, name);
    return true;
}

void Resolver::once(const Rule& rule, const std::vector<Clause>& body, const Head& head, const Term& goal, const std::string& name) {
    if (refused_ || report_.error_count() > errors_before_) return;
    Rule due = rule;
    due.body = body;
    Term place = goal;
    if (program_.worlds != Worlds::Any) place.variable = remembered_at(program_, body, place.variable);
    Variables ways = name_ways(due.body, due);
    ways.erase(place.variable);

    Predicate made;
    made.span = head.span;
    made.arguments = {{Type::Node, ""}};
    made.auxiliary = true;
    Atom way;
    way.arguments = {place};
    way.span = head.span;
    for (const VariableId v : ways) {
        const Variable& variable = due.variables[v];
        made.arguments.push_back({variable.type, ""});
        way.arguments.push_back({.op = Op::Variable, .type = variable.type, .span = head.span, .variable = v});
    }
    const std::string number = fmt::format("{}{}", rule.line, ++rules_once_ > 1 ? fmt::format(".{}", rules_once_) : "");
    made.name = fmt::format("{}@due{}", name, number);
    const auto clause = [&](PredicateId predicate) {
        Clause c{.kind = Clause::Kind::Atom, .atom = way, .span = head.span};
        c.atom.predicate = predicate;
        return c;
    };
    const auto without = [&](PredicateId predicate) {
        Clause c{.kind = Clause::Kind::Not, .span = head.span};
        c.inner.push_back(clause(predicate));
        return c;
    };
    const auto fact = [&](PredicateId predicate) {
        return Head{.kind = Head::Kind::Fact, .atom = clause(predicate).atom, .span = head.span};
    };
    const PredicateId is_due = program_.predicates.add(made);
    made.name = fmt::format("{}@done{}", name, number);
    made.kind = PredicateKind::Linear;
    const PredicateId is_done = program_.predicates.add(std::move(made));

    due.stands_for = body;
    Rule fires = due, forgets = due;
    due.heads = {fact(is_due)};
    place_counts(due);
    fires.linear = forgets.linear = true;
    fires.used_once.clear();
    forgets.used_once.clear();
    fires.body = {clause(is_due), without(is_done)};
    fires.heads = {head, fact(is_done)};
    forgets.body = {clause(is_done), without(is_due)};
    forgets.heads.clear();
    add(std::move(due));
    add(std::move(fires));
    add(std::move(forgets));
}

bool Resolver::is_sent(const std::vector<Clause>& body, const Head& head) const {
    const Predicate& p = program_.predicates[head.atom.predicate];
    if (program_.worlds == Worlds::Any || p.sensed || p.complete_link.valid()) return false;
    const VariableId goal = head.atom.arguments[0].variable;
    bool known = false;
    for (const Clause& c : body) each_variable(c, [&](VariableId v) { known = known || v == goal; });
    return known && remembered_at(program_, body, goal) != goal;
}

void Resolver::sent_view(const Rule& rule, const std::vector<Clause>& body, const Head& head) {
    Predicate sent;
    sent.name = fmt::format("{}@sent{}", program_.predicates[head.atom.predicate].name, rule.line);
    if (++rules_sent_ > 1) sent.name += fmt::format(".{}", rules_sent_);
    sent.span = head.span;
    sent.kind = PredicateKind::Linear;
    sent.auxiliary = true;
    sent.sends = head.atom.predicate;
    for (const Term& argument : head.atom.arguments) sent.arguments.push_back({argument.type, ""});
    Head travels = head, stays = head;
    travels.atom.predicate = program_.predicates.add(std::move(sent));
    once(rule, body, travels);
    // At its goal, with a variable for each argument.
    Rule arrives = rule;
    arrives.variables = {};
    arrives.used_once.clear();
    arrives.linear = true;
    stays.delay = {};
    stays.atom.arguments.clear();
    for (const Term& argument : head.atom.arguments) {
        const std::string name = stays.atom.arguments.empty() ? "A" : fmt::format("X{}", stays.atom.arguments.size());
        const VariableId v = arrives.variables.add({name, argument.span, argument.type});
        stays.atom.arguments.push_back({.op = Op::Variable, .type = argument.type, .span = argument.span, .variable = v});
    }
    Clause fact{.kind = Clause::Kind::Atom, .atom = stays.atom, .span = head.span};
    fact.atom.predicate = travels.atom.predicate;
    arrives.body = {std::move(fact)};
    arrives.heads = {std::move(stays)};
    add(std::move(arrives));
}

}  // namespace meld::check
