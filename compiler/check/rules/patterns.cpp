// Patterns: lists, structs and tuples that contain variables. `p(A, [X | L])` becomes p(A, V), V = [X | L]. Such an equality builds V if X
// and L are known, takes V apart if V is known, and compares if both are known; the planner decides by what the other clauses bind. So that
// one step takes one value apart, the arguments of a constructor are variables or known values: [f(X), Y | L] becomes [V | W], V = f(X), W
// = [Y | L].
#include <algorithm>

#include "compiler/check/names/scope.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

// The parts of a constructor; empty for all else.
std::vector<const syntax::Expr*> parts_of(const syntax::Expr& e) {
    std::vector<const syntax::Expr*> parts;
    const auto add = [&](const std::vector<syntax::ExprPtr>& values) {
        for (const auto& value : values) parts.push_back(value.get());
    };
    if (const auto* l = std::get_if<syntax::ListValue>(&e.node)) {
        add(l->elements);
        if (l->rest) parts.push_back(l->rest.get());
    }
    if (const auto* s = std::get_if<syntax::StructValue>(&e.node)) add(s->fields);
    if (const auto* t = std::get_if<syntax::TupleValue>(&e.node)) add(t->fields);
    if (const auto* c = std::get_if<syntax::Call>(&e.node); c != nullptr && c->parentheses && c->name == "vec3" && c->arguments.size() == 3)
        add(c->arguments);
    return parts;
}

}  // namespace

bool Scope::mentions_variable(const syntax::Expr& e) const {
    if (variable_name(e) != nullptr || std::holds_alternative<syntax::Anonymous>(e.node)) return true;
    const auto any = [this](const std::vector<syntax::ExprPtr>& values) {
        return std::any_of(values.begin(), values.end(), [this](const syntax::ExprPtr& value) { return mentions_variable(*value); });
    };
    if (const auto* c = std::get_if<syntax::Call>(&e.node)) return any(c->arguments);
    if (const auto* u = std::get_if<syntax::Unary>(&e.node)) return mentions_variable(*u->operand);
    if (const auto* b = std::get_if<syntax::Binary>(&e.node)) return mentions_variable(*b->left) || mentions_variable(*b->right);
    if (const auto* c = std::get_if<syntax::Chain>(&e.node))
        return std::any_of(c->operands.begin(), c->operands.end(), [this](const auto& operand) { return mentions_variable(*operand); });
    if (const auto* c = std::get_if<syntax::Conditional>(&e.node))
        return mentions_variable(*c->condition) || mentions_variable(*c->then_value) || mentions_variable(*c->else_value);
    if (const auto* l = std::get_if<syntax::Let>(&e.node)) return mentions_variable(*l->value) || mentions_variable(*l->body);
    const std::vector<const syntax::Expr*> parts = parts_of(e);
    return std::any_of(parts.begin(), parts.end(), [this](const syntax::Expr* part) { return mentions_variable(*part); });
}

bool Scope::is_pattern(const syntax::Expr& e) const { return !parts_of(e).empty() && mentions_variable(e); }

bool Scope::spread_type(const syntax::Expr& e, const Type& type) {
    if (type == Type::Error) return false;
    if (const std::string* name = variable_name(e)) {
        Variable& v = rule_.variables[variable(*name, e.span)];
        const Type before = v.type;
        v.type = refined(v.type, type);
        return v.type != before;
    }
    bool changed = false;
    if (const auto* l = std::get_if<syntax::ListValue>(&e.node)) {
        if (type.parts.size() != 1) return false;
        for (const auto& element : l->elements) changed = spread_type(*element, type.parts[0]) || changed;
        if (l->rest) changed = spread_type(*l->rest, type) || changed;
        return changed;
    }
    const std::vector<const syntax::Expr*> fields = parts_of(e);
    for (std::size_t i = 0; i < fields.size(); ++i) {
        if (type == Type::Vec3)
            changed = spread_type(*fields[i], Type::Float) || changed;
        else if (type.parts.size() == fields.size())
            changed = spread_type(*fields[i], type.parts[i]) || changed;
    }
    return changed;
}

// An argument of a constructor: a variable, a known value, or a fresh variable with its test.
Term Scope::in_pattern(const syntax::Expr& e, const Type& wanted, std::vector<Clause>& tests) {
    Term term;
    term.op = Op::Variable;
    term.span = e.span;
    term.type = wanted;
    if (std::holds_alternative<syntax::Anonymous>(e.node)) {
        term.variable = fresh("_", wanted, e.span);
        return term;
    }
    if (is_pattern(e)) return pattern_variable(e, wanted, tests);
    Term value = resolve(e, wanted, "a part of a pattern");
    if (value.is_variable() || !mentions_variable(e)) return value;
    term.type = value.type;
    term.variable = fresh("_part", value.type, e.span);
    tests.push_back(equality(term, std::move(value), e.span));
    return term;
}

Term Scope::pattern_variable(const syntax::Expr& e, const Type& wanted, std::vector<Clause>& tests) {
    Term variable;
    variable.op = Op::Variable;
    variable.span = e.span;
    const std::size_t at = tests.size();
    Term value = convert(pattern(e, wanted, tests), wanted, "this place");
    variable.type = refined(wanted, value.type);
    variable.variable = fresh("_value", variable.type, e.span);
    // The outer constructor comes before those inside, in reading order.
    tests.insert(tests.begin() + static_cast<std::ptrdiff_t>(at), equality(variable, std::move(value), e.span));
    return variable;
}

Term Scope::pattern(const syntax::Expr& e, const Type& wanted, std::vector<Clause>& tests) {
    Term term;
    term.span = e.span;
    if (const auto* l = std::get_if<syntax::ListValue>(&e.node)) {
        const Type found = infer(e);
        const bool array = wanted.kind == Type::Kind::Array || found.kind == Type::Kind::Array;
        if (wanted.kind == Type::Kind::Set || found.kind == Type::Kind::Set) {
            report_.add(Kind::TypeMismatch, e.span, "a set has no head and no rest").help = "use `E in S` for its elements";
            return term;
        }
        term.type = Type{array ? Type::Kind::Array : Type::Kind::List, {found.parts.size() == 1 ? found.parts[0] : Type::Error}};
        if (wanted.kind == term.type.kind) term.type.parts[0] = join(wanted.parts[0], term.type.parts[0]).value_or(wanted.parts[0]);
        const Type element = term.type.parts[0];
        if (!l->rest) {
            term.op = Op::List;
            for (const auto& part : l->elements) term.operands.push_back(in_pattern(*part, element, tests));
            return term;
        }
        // From the back: each further element is taken from a variable for the rest before it.
        Term rest = in_pattern(*l->rest, term.type, tests);
        term.op = Op::Cons;
        for (std::size_t i = l->elements.size(); i-- > 0;) {
            Term cons = term;
            cons.operands = {in_pattern(*l->elements[i], element, tests), std::move(rest)};
            if (i == 0) return cons;
            rest = Term{.op = Op::Variable, .type = term.type, .span = e.span, .variable = fresh("_rest", term.type, e.span)};
            tests.push_back(equality(rest, std::move(cons), e.span));
        }
    }
    const std::vector<const syntax::Expr*> fields = parts_of(e);
    const bool record = std::holds_alternative<syntax::StructValue>(e.node), vector = std::holds_alternative<syntax::Call>(e.node);
    term.op = record ? Op::Struct : Op::Tuple;
    term.type = vector ? Type::Vec3 : Type{record ? Type::Kind::Struct : Type::Kind::Tuple};
    const bool guided = wanted.kind == term.type.kind && wanted.parts.size() == fields.size();
    for (std::size_t i = 0; i < fields.size(); ++i) {
        const Type type = vector ? Type::Float : guided ? wanted.parts[i] : infer(*fields[i]);
        term.operands.push_back(in_pattern(*fields[i], type, tests));
        if (!vector) term.type.parts.push_back(refined(type, term.operands.back().type));
    }
    return term;
}

}  // namespace meld::check
