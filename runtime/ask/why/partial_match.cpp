#include "runtime/ask/why/partial_match.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "compiler/check/program/library.h"
#include "runtime/engine/tuple/value_text.h"

namespace meld::inspect {

using check::Clause;
using check::Op;
using check::Rule;
using check::Term;
using check::Type;
using check::VariableId;

bool Known::whole() const {
    return catom && std::ranges::all_of(arguments, [](const auto& a) { return a.has_value(); });
}

std::vector<Value> Known::values() const {
    std::vector<Value> out;
    for (const auto& a : arguments) out.push_back(a.value_or(Value{}));
    return out;
}

namespace {

bool ground(const Term& term) {
    bool all = true;
    check::each_variable(term, [&](VariableId) { all = false; });
    return all;
}

// The variable and the constant of V + 1, 1 + V and V - 1.
struct Shifted {
    const Term* variable = nullptr;
    const Term* constant = nullptr;
    bool minus = false;
};
Shifted shifted(const Term& term) {
    if ((term.op != Op::Add && term.op != Op::Subtract) || term.type != Type::Int) return {};
    const Term &a = term.operands[0], &b = term.operands[1];
    if (a.is_variable() && ground(b)) return {&a, &b, term.op == Op::Subtract};
    if (term.op == Op::Add && b.is_variable() && ground(a)) return {&b, &a, false};
    return {};
}

}  // namespace

std::optional<PartialMatch> match_head(const Program& program, Terms& terms, const Rule& rule, const check::Atom& head, const Known& fact,
                                       bool solve, const std::vector<Clause>& more) {
    const check::Predicate& p = program.checked().predicates[fact.predicate];
    PartialMatch out{.of = &rule, .rule = rule, .body = rule.body, .open = !fact.whole()};
    out.values.resize(rule.variables.count());
    out.bound.resize(rule.variables.count());
    // Heads may depend on results of aggregates over matches, which no body says.
    Bound known = bound_by(out);
    const auto is_known = [&](const Term& term) {
        return check::all_free(term, [&](check::VariableId v) { return known[v.index()] || out.bound[v.index()]; });
    };
    for (const Clause& c : more) {
        if (c.kind == Clause::Kind::Test && c.test.op == Op::Equal && c.test.operands[0].is_variable() && is_known(c.test.operands[1]))
            known[c.test.operands[0].variable.index()] = true;
        if (c.kind == Clause::Kind::Test && !is_known(c.test)) continue;
        out.body.push_back(c);
        const Bound all = bound_by(out);
        for (std::size_t v = 0; v < all.size(); ++v) known[v] = known[v] || all[v];
    }
    out.own = out.body.size();
    const auto bind = [&](VariableId v, Value value) {
        out.values[v.index()] = value;
        out.bound[v.index()] = true;
    };
    const auto is_bound = [&](VariableId v) { return out.bound[v.index()]; };
    bool fits = true;
    const auto one = [&](const Term& term, const Type& type, Value value) {
        if (term.op == Op::Anonymous || !cannot(program.checked(), term).empty()) return;
        if (term.is_variable() && !is_bound(term.variable)) {
            const Type& own = rule.variables[term.variable].type;
            if (own == Type::Int && type == Type::Float) {
                fits = value.real >= -0x1p63 && value.real < 0x1p63 && value.real == std::trunc(value.real);
                if (!fits) return;
                value = {.integer = static_cast<i64>(value.real)};
            }
            return bind(term.variable, value);
        }
        if (ground(term)) {
            const Value is = terms.value_as(term, type, out.values);
            fits = fits && terms.scratch.went_well() && terms.equal(type, is, value);
            return;
        }
        if (const Shifted shift = shifted(term); solve && shift.variable != nullptr && !is_bound(shift.variable->variable)) {
            const i64 by = terms.value(*shift.constant, out.values).integer;
            i64 is = 0;
            if (terms.scratch.went_well() &&
                !(shift.minus ? __builtin_add_overflow(value.integer, by, &is) : __builtin_sub_overflow(value.integer, by, &is)))
                return bind(shift.variable->variable, {.integer = is});
        }
        if (!is_known(term)) return;
        const VariableId wanted = out.rule.variables.add({tuple::print_value(terms.types.of(type), value), term.span, type});
        out.values.push_back(value);
        out.bound.push_back(true);
        Term variable{.op = Op::Variable, .type = type, .span = term.span};
        variable.variable = wanted;
        Term left = term;
        if (term.type == Type::Int && type == Type::Float) {
            left = {.op = Op::ToFloat, .type = Type::Float, .span = term.span};
            left.operands = {term};
        }
        Clause test{.kind = Clause::Kind::Test, .span = term.span};
        test.test = {.op = Op::Equal, .type = Type::Bool, .span = term.span};
        test.test.operands = {std::move(left), std::move(variable)};
        out.body.push_back(std::move(test));
    };
    if (fact.catom) one(head.arguments[0], Type::Node, {.catom = *fact.catom});
    // What the head names itself may be used in what it computes.
    for (const bool variables : {true, false})
        for (std::size_t i = 0; i < fact.arguments.size() && fits; ++i)
            if (const Term& term = head.arguments[i + 1]; fact.arguments[i] && term.is_variable() == variables)
                one(term, p.arguments[i + 1].type, *fact.arguments[i]);
    if (!fits) return std::nullopt;
    return out;
}

std::string cannot(const check::Program& checked, const Term& term) {
    std::string why;
    std::set<check::FunctionId> seen;
    const auto look = [&](const auto& self, const Term& whole) -> void {
        check::each_subterm(whole, [&](const Term& t) {
            if (t.op == Op::Now || t.op == Op::Ticks || t.op == Op::Due || t.op == Op::Fresh) why = "it asks for the time";
            const check::LibraryFunction* const f = t.op == Op::Library ? check::library_function(t.text, t.operands.size()) : nullptr;
            if (f != nullptr && f->random) why = "it draws random numbers";
            if (t.op == Op::Call && checked.functions[t.function].external) why = "it calls a function in C";
            if (t.op == Op::Call && seen.insert(t.function).second) self(self, checked.functions[t.function].body);
        });
    };
    look(look, term);
    return why;
}

std::string cannot(const Program& program, const std::vector<Clause>& body) {
    std::string why;
    const auto look = [&](const Term& term) {
        if (const std::string of_term = cannot(program.checked(), term); !of_term.empty()) why = of_term;
    };
    for (const Clause& c : body) {
        if (c.kind == Clause::Kind::Delta) return "it asks for a change";
        for (const Term& t : c.atom.arguments) look(t);
        look(c.test);
        if (const std::string inner = cannot(program, c.inner); !inner.empty()) why = inner;
    }
    if (!why.empty()) return why;
    if (const auto can = program.can_ask(body); !can) return can.error().problem;
    return "";
}

void bind_by(const std::vector<Clause>& body, Bound& bound) {
    const auto bind = [&](const Term& term) { check::each_free_use(term, [&](const Term& t) { bound[t.variable.index()] = true; }); };
    for (const Clause& c : body) {
        for (const Term& t : c.atom.arguments) bind(t);
        if (c.kind == Clause::Kind::Test) bind(c.test);
        if (c.kind == Clause::Kind::Element || c.kind == Clause::Kind::Aggregate) bound[c.variable.index()] = true;
        if (c.kind == Clause::Kind::Element && c.position.valid()) bound[c.position.index()] = true;
    }
}

Bound bound_by(const PartialMatch& match) {
    Bound out = match.bound;
    bind_by(match.body, out);
    return out;
}

}  // namespace meld::inspect
