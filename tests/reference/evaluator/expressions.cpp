#include "tests/reference/evaluator/expressions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/reference/evaluator/library.h"

namespace meld::reference {

using check::Op;
using check::Term;

namespace {

using I = std::int64_t;
using Result = std::optional<Value>;

constexpr I kLeast = INT64_MIN;

Result power(I a, I b) {
    if (b < 0) return std::nullopt;
    // Whatever the exponent, these need no more than a look at it; the others overflow after 63 steps at most.
    if (a == 0 || a == 1) return value_of(b == 0 ? I{1} : a);
    if (a == -1) return value_of(b % 2 == 0 ? I{1} : I{-1});
    I result = 1;
    for (I i = 0; i < b; ++i)
        if (__builtin_mul_overflow(result, a, &result)) return std::nullopt;
    return value_of(result);
}

Result integers(Op op, I a, I b) {
    I result = 0;
    switch (op) {
        case Op::Add:
            return __builtin_add_overflow(a, b, &result) ? Result() : value_of(result);
        case Op::Subtract:
            return __builtin_sub_overflow(a, b, &result) ? Result() : value_of(result);
        case Op::Multiply:
            return __builtin_mul_overflow(a, b, &result) ? Result() : value_of(result);
        case Op::Divide:
            return b == 0 || (b == -1 && a == kLeast) ? Result() : value_of(a / b);
        case Op::Modulo:
            return b == 0 ? Result() : b == -1 ? value_of(I{0}) : value_of(a % b);
        default:
            return power(a, b);
    }
}

Result reals(Op op, double a, double b) {
    switch (op) {
        case Op::Add:
            return value_of(a + b);
        case Op::Subtract:
            return value_of(a - b);
        case Op::Multiply:
            return value_of(a * b);
        case Op::Divide:
            return b == 0 ? Result() : value_of(a / b);
        case Op::Modulo:
            return b == 0 ? Result() : value_of(std::fmod(a, b));
        default:
            return value_of(std::pow(a, b));
    }
}

bool compared(Op op, const Value& a, const Value& b) {
    switch (op) {
        case Op::Equal:
            return a == b;
        case Op::NotEqual:
            return a != b;
        case Op::Less:
            return a < b;
        case Op::LessEqual:
            return a <= b;
        case Op::Greater:
            return a > b;
        default:
            return a >= b;
    }
}

Result truncated(double a) {
    if (!(a >= -9223372036854775808.0 && a < 9223372036854775808.0)) return std::nullopt;
    return value_of(static_cast<I>(a));
}

Result unary(Op op, const Value& a) {
    switch (op) {
        case Op::Negate:
            if (a.has_items()) {
                Values out;
                for (const Value& x : a.items()) out.push_back(value_of(-x.real()));
                return value_of(std::move(out));
            }
            return a.is_real() ? value_of(-a.real()) : integers(Op::Subtract, 0, a.integer());
        case Op::Not:
            return value_of(!a.truth());
        case Op::ToFloat:
            return value_of(static_cast<double>(a.integer()));
        case Op::Abs:
            return a.is_real() ? value_of(std::fabs(a.real())) : a.integer() < 0 ? integers(Op::Subtract, 0, a.integer()) : Result(a);
        case Op::Truncate:
            return truncated(a.real());
        case Op::Sqrt:
            return value_of(std::sqrt(a.real()));
        default:
            return a;  // NodeToInt
    }
}

Result binary(Op op, const Value& a, const Value& b) {
    switch (op) {
        case Op::Equal:
        case Op::NotEqual:
        case Op::Less:
        case Op::LessEqual:
        case Op::Greater:
        case Op::GreaterEqual:
            return value_of(compared(op, a, b));
        case Op::Min:
            return b < a ? b : a;
        case Op::Max:
            return a < b ? b : a;
        default:
            return a.is_real() ? reals(op, a.real(), b.real()) : integers(op, a.integer(), b.integer());
    }
}

Result constant_of(const Scene& scene, const check::Constant& c) {
    if (c.computed.valid()) return call(scene, c.computed, {});
    if (c.type == check::Type::String) return Value{c.text};
    if (c.type.compound()) return evaluate(scene, c.value, {});
    return is_real(c.type) ? value_of(c.real) : value_of(c.integer);
}

// ---- values with items

Result vector(Op op, const Values& a, const Value& b) {
    Values sum;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double other = b.has_items() ? b.items()[i].real() : b.real();
        // v - w is v + w * -1, which matters for the sign of zero alone.
        const Result one = reals(op == Op::Subtract ? Op::Add : op, a[i].real(), op == Op::Subtract ? other * -1 : other);
        if (!one || !is_finite(*one)) return std::nullopt;
        sum.push_back(*one);
    }
    return value_of(std::move(sum));
}

Result joined(const Value& a, const Value& b) {
    if (a.is_text()) return Value{a.text() + b.text()};
    Values all = a.items();
    all.insert(all.end(), b.items().begin(), b.items().end());
    return value_of(std::move(all));
}

Result cons(const Value& head, const Value& tail) {
    Values all{head};
    all.insert(all.end(), tail.items().begin(), tail.items().end());
    return value_of(std::move(all));
}

// What the library's random functions make of 64 bits.
Result drawn(const Scene& scene, const std::string& name, const Values& arguments) {
    if (name == "randint" && arguments[0].integer() <= 0) return std::nullopt;
    const std::uint64_t bits = scene.chance->next();
    if (name != "randint") return value_of(static_cast<double>(bits >> 11) / 9007199254740992.0);
    // The whole part of the bits as a fraction, times the argument.
    __extension__ using Wide = unsigned __int128;
    return value_of(static_cast<I>((static_cast<Wide>(bits) * static_cast<std::uint64_t>(arguments[0].integer())) >> 64));
}

Result ticks_in(double seconds) { return value_of(std::max(I{1}, static_cast<I>(std::floor(seconds / kTick_seconds + 0.5)))); }

}  // namespace

// Its parameters are the first of its variables.
std::optional<Value> call(const Scene& scene, check::FunctionId function, const Values& arguments) {
    const check::Function& f = scene.program->functions[function];
    Environment env(f.variables.count());
    std::copy(arguments.begin(), arguments.end(), env.begin());
    return evaluate(scene, f.body, env);
}

std::optional<Value> added(const Value& a, const Value& b) {
    if (!a.has_items()) return a.is_real() ? reals(Op::Add, a.real(), b.real()) : integers(Op::Add, a.integer(), b.integer());
    Values sum;
    for (std::size_t i = 0; i < std::min(a.items().size(), b.items().size()); ++i)
        sum.push_back(value_of(a.items()[i].real() + b.items()[i].real()));
    return value_of(std::move(sum));
}

namespace {

// What a sum of nothing is. Nothing: sums of lists begin with the first one.
Result sum_of_nothing(const check::Type& type, bool any) {
    if (is_real(type)) return value_of(0.0);
    if (!type.compound()) return value_of(I{0});
    if (any) return std::nullopt;
    return value_of(type == check::Type::Vec3 ? Values(3, value_of(0.0)) : Values());
}

}  // namespace

double mean(const Values& values) {
    // With 113 bits the sum of a test's values is exact, and the quotient far finer than a double.
    __extension__ __float128 sum = 0;
    for (const Value& v : values) sum += v.is_real() ? v.real() : static_cast<double>(v.integer());
    return static_cast<double>(sum / static_cast<double>(values.size())) + 0.0;
}

Values best_of(Values values, std::int64_t limit, bool least) {
    std::sort(values.begin(), values.end(), [&](const Value& a, const Value& b) { return least ? a < b : b < a; });
    values.resize(static_cast<std::size_t>(std::clamp<std::int64_t>(limit, 0, static_cast<std::int64_t>(values.size()))));
    return values;
}

Folded fold(const Scene& scene, const FoldRule& rule, const Values& values) {
    using check::Aggregate;
    if (rule.aggregate == Aggregate::Count) return {.value = value_of(static_cast<I>(values.size()))};
    if (rule.aggregate == Aggregate::Collect) return {.value = value_of(values)};
    if (rule.aggregate == Aggregate::Avg) return values.empty() ? Folded{} : Folded{.value = value_of(mean(values))};
    if (rule.aggregate == Aggregate::MinK || rule.aggregate == Aggregate::MaxK) {
        if (!rule.parameter) return {.failed = true};
        return {.value = value_of(best_of(values, rule.parameter->integer(), rule.aggregate == Aggregate::MinK))};
    }
    if (rule.aggregate == Aggregate::And || rule.aggregate == Aggregate::Or) {
        const bool and_all = rule.aggregate == Aggregate::And;
        const auto differs = [&](const Value& v) { return v.truth() != and_all; };
        return {.value = value_of(std::any_of(values.begin(), values.end(), differs) ? !and_all : and_all)};
    }
    Result total = rule.parameter;
    if (rule.aggregate == Aggregate::Sum) total = sum_of_nothing(rule.type, !values.empty());
    for (const Value& v : values) {
        if (!total)
            total = v;
        else if (rule.aggregate == Aggregate::Sum)
            total = added(*total, v);
        else if (rule.aggregate == Aggregate::Min)
            total = std::min(*total, v);
        else if (rule.aggregate == Aggregate::Max)
            total = std::max(*total, v);
        else
            total = call(scene, rule.function, {*total, v});
        if (!total) return {.failed = true};
    }
    return {.value = total};
}

bool all_bound(const Term& term, const Environment& env) {
    bool all = true;
    check::each_variable(term, [&](check::VariableId v) { all = all && env[v.index()].has_value(); });
    return all;
}

std::optional<Value> evaluate(const Scene& scene, const Term& term, const Environment& env) {
    switch (term.op) {
        case Op::Variable:
            return env[term.variable.index()];
        case Op::Int:
        case Op::Bool:
        case Op::Node:
            return value_of(term.integer);
        case Op::Float:
            return value_of(term.real);
        case Op::String:
            return Value{term.text};
        case Op::Constant:
            return constant_of(scene, scene.program->constants[term.constant]);
        case Op::WorldSize:
            return value_of(scene.first_catoms);
        case Op::Now:
            return value_of(scene.tick);
        // Values that nobody else has: ints from 0, and ids of no catom.
        case Op::Fresh:
            return value_of(static_cast<I>(term.type == check::Type::Node ? scene.chance->next() | (std::uint64_t{1} << 63)
                                                                          : scene.chance->next() >> 1));
        case Op::And:
        case Op::Or:
        case Op::If: {
            // These look at their other operands only where the first leaves the answer open.
            const Result first = evaluate(scene, term.operands[0], env);
            if (!first) return std::nullopt;
            if (term.op == Op::If) return evaluate(scene, term.operands[first->truth() ? 1 : 2], env);
            return first->truth() == (term.op == Op::And) ? evaluate(scene, term.operands[1], env) : first;
        }
        case Op::Let: {
            Environment inner = env;
            inner[term.variable.index()] = evaluate(scene, term.operands[0], env);
            return inner[term.variable.index()] ? evaluate(scene, term.operands[1], inner) : std::nullopt;
        }
        default:
            break;
    }
    Values operands;
    for (const Term& operand : term.operands) {
        const Result value = evaluate(scene, operand, env);
        if (!value || (term.op >= Op::List && term.op <= Op::Tuple && !is_finite(*value))) return std::nullopt;
        operands.push_back(*value);
    }
    switch (term.op) {
        case Op::List:
            // A set is written as a list.
            if (term.type.kind == check::Type::Kind::Set) {
                std::sort(operands.begin(), operands.end());
                operands.erase(std::unique(operands.begin(), operands.end()), operands.end());
            }
            return value_of(std::move(operands));
        case Op::Struct:
        case Op::Tuple:
            return value_of(std::move(operands));
        case Op::Cons:
            return cons(operands[0], operands[1]);
        case Op::Append:
            return joined(operands[0], operands[1]);
        case Op::Ticks:
            return ticks_in(operands[0].real());
        case Op::Library: {
            if (term.text == "randint" || term.text == "randfloat" || term.text == "random") return drawn(scene, term.text, operands);
            Result result =
                term.text == "intpower" ? power(operands[0].integer(), operands[1].integer()) : call_library(term.text, operands);
            return result && is_finite(*result) ? result : std::nullopt;
        }
        case Op::Call:
            return call(scene, term.function, operands);
        default:
            break;
    }
    if (operands.size() == 1) return unary(term.op, operands[0]);
    const bool arithmetic = term.op >= Op::Add && term.op <= Op::Power;
    if (arithmetic && operands[0].has_items()) return vector(term.op, operands[0].items(), operands[1]);
    if (arithmetic && operands[1].has_items()) return vector(term.op, operands[1].items(), operands[0]);
    return binary(term.op, operands[0], operands[1]);
}

}  // namespace meld::reference
