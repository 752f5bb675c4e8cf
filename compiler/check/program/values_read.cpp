#include "compiler/check/program/values_read.h"

#include <algorithm>

#include "runtime/base/assert.h"

namespace meld::check {

namespace {

bool constant(const Term& t) {
    bool any = false;
    each_variable(t, [&](VariableId) { any = true; });
    bool calls = false;
    each_subterm(t, [&](const Term& part) {
        calls = calls || part.op == Op::Call || part.op == Op::Library || part.op == Op::Now || part.op == Op::Due;
    });
    return !any && !calls;
}

// X > 3 for a max, X < 3 for a min: better values pass too.
bool monotone(const Term& test, VariableId value, Aggregate aggregate) {
    if (test.op < Op::Less || test.op > Op::GreaterEqual) return false;
    const bool left = test.operands[0].is_variable() && test.operands[0].variable == value && constant(test.operands[1]);
    const bool right = test.operands[1].is_variable() && test.operands[1].variable == value && constant(test.operands[0]);
    const bool less = test.op == Op::Less || test.op == Op::LessEqual;
    return (left && less == keeps_least(aggregate)) || (right && less == keeps_greatest(aggregate));
}

bool mentions(const Term& t, VariableId v) {
    bool found = false;
    each_variable(t, [&](VariableId use) { found = found || use == v; });
    return found;
}

// Calls visit(expression) with what variables are equal to in the body, until it returns true; returns whether it did.
template <class Visit>
bool any_definition(const Rule& rule, VariableId v, const Visit& visit) {
    return std::any_of(rule.body.begin(), rule.body.end(), [&](const Clause& c) {
        if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) return false;
        for (const std::size_t side : {0u, 1u}) {
            const Term &target = c.test.operands[side], &other = c.test.operands[1 - side];
            if (target.is_variable() && target.variable == v && !other.is_variable() && visit(other)) return true;
        }
        return false;
    });
}

}  // namespace

std::size_t uses(const Rule& rule, VariableId v) {
    MELD_EXPECT(v.valid() && v.index() < rule.variables.count(), "rule {} has no variable {}", rule.name, v.index());
    std::size_t n = 0;
    const auto count = [&](VariableId use) { n += use == v; };
    for (const Clause& c : rule.body) each_variable(c, count);
    for (const Head& h : rule.heads) each_variable(h, count);
    return n;
}

ValueRead value_read(const Program& program, const Rule& rule, const Atom& atom) {
    const Predicate& p = program.predicates[atom.predicate];
    MELD_EXPECT(atom.arguments.size() == p.arguments.size(), "{} with {} arguments", p.signature(), atom.arguments.size());
    if (!keeps_best(p.aggregate)) return {};
    ValueRead used{.kind = ValueRead::Kind::Used};
    for (std::size_t i = p.aggregate_at + 1; i < atom.arguments.size(); ++i) {
        const Term& payload = atom.arguments[i];
        if (payload.op != Op::Anonymous && (!payload.is_variable() || uses(rule, payload.variable) > 1)) return used;
    }
    ValueRead exists{.kind = ValueRead::Kind::Exists};
    const Term& value = atom.arguments[p.aggregate_at];
    if (value.op == Op::Anonymous) return exists;
    if (!value.is_variable()) return used;
    std::size_t accounted = 1;
    for (std::size_t i = 0; i < rule.body.size(); ++i) {
        const Clause& c = rule.body[i];
        if (c.kind != Clause::Kind::Test || !monotone(c.test, value.variable, p.aggregate)) continue;
        exists.tests.push_back(i);
        ++accounted;
    }
    return uses(rule, value.variable) == accounted ? exists : used;
}

std::optional<std::array<Rule, 2>> sides_of_best(const Program& program, const Rule& rule) {
    MELD_EXPECT(!rule.linear && rule.heads.size() == 1, "rule {} is no view", rule.name);
    const Predicate& p = program.predicates[rule.heads[0].atom.predicate];
    if (!keeps_best(p.aggregate)) return std::nullopt;
    const Term& made = rule.heads[0].atom.arguments[p.aggregate_at];
    if (made.op != (keeps_greatest(p.aggregate) ? Op::Max : Op::Min)) return std::nullopt;
    std::array<Rule, 2> sides = {rule, rule};
    for (std::size_t i = 0; i < 2; ++i) sides[i].heads[0].atom.arguments[p.aggregate_at] = made.operands[i];
    return sides;
}

bool computed_from(const Rule& rule, const Term& e, VariableId value) {
    if (mentions(e, value)) return true;
    return e.is_variable() && any_definition(rule, e.variable, [&](const Term& is) { return mentions(is, value); });
}

bool improves(const Rule& rule, const Term& e, VariableId value, Aggregate aggregate, Improves how) {
    MELD_EXPECT(keeps_best(aggregate) && value.valid(), "rule {}: nothing is better", rule.name);
    if (e.is_variable())
        return e.variable != value &&
               any_definition(rule, e.variable, [&](const Term& is) { return improves(rule, is, value, aggregate, how); });
    if (!mentions(e, value)) return false;
    if (e.op == Op::Max || e.op == Op::Min || e.op == Op::ToFloat) {
        const auto operand = [&](const Term& o) { return improves(rule, o, value, aggregate, how); };
        const bool worst = e.op == (keeps_least(aggregate) ? Op::Max : Op::Min);
        return how == Improves::Ever && worst ? std::all_of(e.operands.begin(), e.operands.end(), operand)
                                              : std::any_of(e.operands.begin(), e.operands.end(), operand);
    }
    if (e.op != Op::Add && e.op != Op::Subtract) return false;
    const bool left = mentions(e.operands[0], value);
    const Term& step = e.operands[left ? 1 : 0];
    const bool number = (step.op == Op::Int && step.integer > 0) || (step.op == Op::Float && step.real > 0);
    return number && (left || e.op == Op::Add) && (e.op == Op::Add) == keeps_greatest(aggregate);
}

}  // namespace meld::check
