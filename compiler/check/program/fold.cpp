// An interpreter of terms. It knows operators, lists and functions of the program; calls of the library or of an extern, and long
// computations, are left to the run.
#include "compiler/check/program/fold.h"

namespace meld::check {

namespace {

// A longer computation is done where the constant is used.
constexpr std::size_t kMaxSteps = 100'000;
constexpr std::size_t kMaxDepth = 2'000;

Term literal(Op op, const Type& type, Span span) {
    Term t;
    t.op = op;
    t.type = type;
    t.span = span;
    return t;
}
Term truth(bool value, Span span) {
    Term t = literal(Op::Bool, Type::Bool, span);
    t.integer = value;
    return t;
}
double as_real(const Term& t) { return t.op == Op::Float ? t.real : static_cast<double>(t.integer); }

template <class V>
int three_way(const V& a, const V& b) {
    return a < b ? -1 : b < a ? 1 : 0;
}
// The order of runtime/module/kernel/library.h.
int compare(const Term& a, const Term& b) {
    if (a.op == Op::String) return three_way(a.text, b.text);
    if (a.op == Op::Float || b.op == Op::Float) return three_way(as_real(a), as_real(b));
    if (a.op != Op::List && a.op != Op::Struct && a.op != Op::Tuple)
        return a.op == Op::Int ? three_way(a.integer, b.integer)
                               : three_way(static_cast<std::uint64_t>(a.integer), static_cast<std::uint64_t>(b.integer));
    for (std::size_t i = 0; i < a.operands.size() && i < b.operands.size(); ++i)
        if (const int c = compare(a.operands[i], b.operands[i])) return c;
    return three_way(a.operands.size(), b.operands.size());
}
}  // namespace

std::nullopt_t Folder::fails(const Term& t, const std::string& why) {
    if (wrong_.empty()) {
        wrong_ = why;
        wrong_at_ = t.span;
    }
    return std::nullopt;
}

std::optional<Term> Folder::fold(const Term& term) {
    if (++steps_ > kMaxSteps || depth_ > kMaxDepth) return std::nullopt;
    ++depth_;
    std::optional<Term> result = value(term);
    --depth_;
    return result;
}

std::optional<Term> Folder::value(const Term& t) {
    const auto operand = [&](std::size_t i) { return fold(t.operands[i]); };
    switch (t.op) {
        case Op::Int:
        case Op::Float:
        case Op::Bool:
        case Op::Node:
        case Op::String:
            return t;
        case Op::Variable: {
            const auto found = variables_.find(t.variable);
            return found == variables_.end() ? std::nullopt : std::optional(found->second);
        }
        case Op::Constant:
            return constant_(t.constant);
        case Op::List:
        case Op::Struct:
        case Op::Tuple:
        case Op::Cons:
        case Op::Append:
            return compound(t);
        case Op::Call:
            return call(t);
        case Op::Let: {
            std::optional<Term> inner = operand(0);
            if (!inner) return std::nullopt;
            variables_[t.variable] = std::move(*inner);
            return operand(1);
        }
        case Op::If: {
            const std::optional<Term> condition = operand(0);
            if (!condition) return std::nullopt;
            std::optional<Term> chosen = operand(condition->integer ? 1 : 2);
            if (chosen && t.type == Type::Float && chosen->op == Op::Int) return real(t, compute(Op::ToFloat, as_real(*chosen), 0));
            return chosen;
        }
        case Op::And:
        case Op::Or: {
            std::optional<Term> left = operand(0);
            if (!left || (left->integer != 0) == (t.op == Op::Or)) return left;
            return operand(1);
        }
        case Op::Not: {
            const std::optional<Term> inner = operand(0);
            return inner ? std::optional(truth(inner->integer == 0, t.span)) : std::nullopt;
        }
        default:
            break;
    }
    if (t.operands.empty() || t.operands.size() > 2 || t.op == Op::Library) return std::nullopt;
    const std::optional<Term> a = operand(0), b = t.operands.size() == 2 ? operand(1) : a;
    if (!a || !b) return std::nullopt;
    if (t.op >= Op::Equal && t.op <= Op::GreaterEqual) return truth(holds(t.op, compare(*a, *b), 0), t.span);
    return arithmetic(t, *a, *b);
}

std::optional<Term> Folder::arithmetic(const Term& t, const Term& a, const Term& b) {
    if (t.op == Op::NodeToInt) return whole(t, {.value = a.integer});
    if (t.op == Op::Truncate) {
        const double d = as_real(a);
        if (!(d >= -9223372036854775808.0 && d < 9223372036854775808.0)) return fails(t, "this does not fit into 64 bits");
        return whole(t, {.value = static_cast<std::int64_t>(d)});
    }
    const bool makes_float = t.op == Op::ToFloat || t.op == Op::Sqrt;
    if (t.type == Type::Int && !makes_float) return whole(t, compute(t.op, a.integer, b.integer));
    if (t.type == Type::Float || makes_float) return real(t, compute(t.op, as_real(a), as_real(b)));
    return std::nullopt;
}

std::optional<Term> Folder::whole(const Term& t, const Computed<std::int64_t>& result) {
    if (result.problem != nullptr) return fails(t, result.problem);
    if (!result.value) return std::nullopt;
    Term out = literal(Op::Int, Type::Int, t.span);
    out.integer = *result.value;
    return out;
}

std::optional<Term> Folder::real(const Term& t, const Computed<double>& result) {
    if (result.problem != nullptr) return fails(t, result.problem);
    if (!result.value) return std::nullopt;
    Term out = literal(Op::Float, Type::Float, t.span);
    out.real = *result.value;
    return out;
}

// Lists and what joins them. Sets are sorted by the run.
std::optional<Term> Folder::compound(const Term& t) {
    if (t.type.kind == Type::Kind::Set) return std::nullopt;
    std::vector<Term> operands;
    for (const Term& operand : t.operands) {
        std::optional<Term> value = fold(operand);
        if (!value) return std::nullopt;
        operands.push_back(std::move(*value));
    }
    if (t.op == Op::Append && t.type == Type::String) {
        Term out = literal(Op::String, t.type, t.span);
        out.text = operands[0].text + operands[1].text;
        return out;
    }
    Term out = literal(t.op == Op::Struct || t.op == Op::Tuple ? t.op : Op::List, t.type, t.span);
    if (t.op == Op::Cons) {
        out.operands.push_back(std::move(operands[0]));
        out.operands.insert(out.operands.end(), operands[1].operands.begin(), operands[1].operands.end());
    } else if (t.op == Op::Append) {
        out.operands = std::move(operands[0].operands);
        out.operands.insert(out.operands.end(), operands[1].operands.begin(), operands[1].operands.end());
    } else {
        out.operands = std::move(operands);
    }
    steps_ += out.operands.size();
    return out;
}

std::optional<Term> Folder::call(const Term& t) {
    const Function& f = program_.functions[t.function];
    if (f.external || f.refused) return std::nullopt;
    std::map<VariableId, Term> inner;
    for (std::size_t i = 0; i < t.operands.size(); ++i) {
        std::optional<Term> argument = fold(t.operands[i]);
        if (!argument) return std::nullopt;
        inner[VariableId(i)] = std::move(*argument);
    }
    std::swap(inner, variables_);
    std::optional<Term> result = fold(f.body);
    std::swap(inner, variables_);
    return result;
}

}  // namespace meld::check
