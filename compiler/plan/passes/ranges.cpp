#include "compiler/plan/passes/ranges.h"

#include <algorithm>

#include "compiler/check/program/operators.h"

namespace meld::plan {

using namespace check;

Range either(const Range& a, const Range& b) {
    if (a.is_empty()) return b;
    if (b.is_empty()) return a;
    return {std::min(a.least, b.least), std::max(a.greatest, b.greatest)};
}
Range both(const Range& a, const Range& b) { return {std::max(a.least, b.least), std::min(a.greatest, b.greatest)}; }

Range sum(const Range& a, const Range& b) {
    Range r;
    if (a.is_empty() || b.is_empty()) return Range::empty();
    if (a.least == INT64_MIN || b.least == INT64_MIN || __builtin_add_overflow(a.least, b.least, &r.least)) r.least = INT64_MIN;
    if (a.greatest == INT64_MAX || b.greatest == INT64_MAX || __builtin_add_overflow(a.greatest, b.greatest, &r.greatest))
        r.greatest = INT64_MAX;
    return r;
}
Range negative(const Range& a) {
    if (a.is_empty()) return a;
    return {a.greatest == INT64_MAX ? INT64_MIN : -a.greatest, a.least == INT64_MIN ? INT64_MAX : -a.least};
}

namespace {

// Factors of at most 31 bits, so that no product overflows.
Range product(const Range& a, const Range& b) {
    constexpr std::int64_t most = INT32_MAX;
    if (a.is_empty() || b.is_empty()) return Range::empty();
    if (std::min(a.least, b.least) < -most || std::max(a.greatest, b.greatest) > most) return {};
    const auto [least, greatest] = std::minmax({a.least * b.least, a.least * b.greatest, a.greatest * b.least, a.greatest * b.greatest});
    return {least, greatest};
}
// The remainder has the sign of the dividend.
Range remainder(const Range& a, const Term& by) {
    if (a.is_empty() || by.op != Op::Int || by.integer == 0 || by.integer == INT64_MIN) return a.is_empty() ? a : Range{};
    const std::int64_t most = std::abs(by.integer) - 1;
    return both({a.least < 0 ? -most : 0, a.greatest > 0 ? most : 0},
                {std::min<std::int64_t>(a.least, 0), std::max<std::int64_t>(a.greatest, 0)});
}

// The possible values of a variable if `variable op other` holds.
Range where(Op op, const Range& other) {
    if (other.is_empty()) return other;
    switch (op) {
        case Op::Equal:
            return other;
        case Op::Less:
            return {INT64_MIN, other.greatest == INT64_MIN ? INT64_MIN : other.greatest - (other.greatest != INT64_MAX)};
        case Op::LessEqual:
            return {INT64_MIN, other.greatest};
        case Op::Greater:
            return {other.least == INT64_MAX ? INT64_MAX : other.least + (other.least != INT64_MIN), INT64_MAX};
        case Op::GreaterEqual:
            return {other.least, INT64_MAX};
        default:
            return {};
    }
}

}  // namespace

Range range_of(const Term& t, const KnownRanges& known) {
    const auto operand = [&](std::size_t i) { return range_of(t.operands[i], known); };
    if (t.type != Type::Int) return {};
    switch (t.op) {
        case Op::Int:
            return {t.integer, t.integer};
        case Op::Variable: {
            const auto found = known.find(t.variable);
            return found == known.end() ? Range{} : found->second;
        }
        case Op::Add:
            return sum(operand(0), operand(1));
        case Op::Subtract:
            return sum(operand(0), negative(operand(1)));
        case Op::Negate:
            return negative(operand(0));
        case Op::Multiply:
            return product(operand(0), operand(1));
        case Op::Modulo:
            return remainder(operand(0), t.operands[1]);
        case Op::If:
            return either(operand(1), operand(2));
        case Op::Min: {
            const Range a = operand(0), b = operand(1);
            return {std::min(a.least, b.least), std::min(a.greatest, b.greatest)};
        }
        case Op::Max: {
            const Range a = operand(0), b = operand(1);
            return {std::max(a.least, b.least), std::max(a.greatest, b.greatest)};
        }
        default:
            return {};
    }
}

bool understand(const Program& program, const Rule& rule, const std::function<Range(PredicateId, std::size_t)>& of, KnownRanges& known) {
    const auto meet = [&](VariableId v, const Range& r) {
        if (rule.variables[v].type != Type::Int) return;
        const auto [at, is_new] = known.emplace(v, r);
        if (!is_new) at->second = both(at->second, r);
    };
    // A test may be about a variable that a later one gives its value.
    for (int again = 0; again < 3; ++again)
        for (const Clause& c : rule.body) {
            if (c.kind == Clause::Kind::Atom)
                for (std::size_t i = 1; i < c.atom.arguments.size(); ++i) {
                    const Range r = of(c.atom.predicate, i);
                    const Type& type = program.predicates[c.atom.predicate].arguments[i].type;
                    if (type == Type::Int && r.is_empty()) return false;
                    if (type == Type::Int && c.atom.arguments[i].is_variable()) meet(c.atom.arguments[i].variable, r);
                }
            if (c.kind != Clause::Kind::Test || c.test.operands.size() != 2 || c.test.operands[0].type != Type::Int ||
                c.test.operands[1].type != Type::Int)
                continue;
            for (const bool left : {true, false}) {
                const Term &one = c.test.operands[left ? 0 : 1], &other = c.test.operands[left ? 1 : 0];
                if (one.is_variable()) meet(one.variable, where(left ? c.test.op : turned(c.test.op), range_of(other, known)));
            }
        }
    return std::none_of(known.begin(), known.end(), [](const auto& k) { return k.second.is_empty(); });
}

}  // namespace meld::plan
