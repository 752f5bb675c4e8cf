#include "compiler/lint/linear_form.h"

#include "compiler/lint/differences.h"

namespace meld::lint {

using namespace check;

namespace {

// Small enough that no sum of a rule's factors and literals overflows.
constexpr std::int64_t kLargestFactor = std::int64_t{1} << 20;

class Adder {
  public:
    Adder(const Program& program, const Rule& rule) : program_(program), rule_(rule) {}

    // Adds factor * t; false where that cannot be.
    bool add(const Term& t, std::int64_t factor) {
        if (t.op == Op::Int) return small(t.integer, Differences::kLargest) && rest(t.integer, factor);
        if (t.op == Op::Negate) return add(t.operands[0], -factor);
        if (t.op == Op::Add) return add(t.operands[0], factor) && add(t.operands[1], factor);
        if (t.op == Op::Subtract) return add(t.operands[0], factor) && add(t.operands[1], -factor);
        if (t.op == Op::Multiply)
            for (const std::size_t side : {0u, 1u})
                if (const Term& by = t.operands[side]; by.op == Op::Int)
                    return small(by.integer, kLargestFactor) && small(by.integer * factor, kLargestFactor) &&
                           add(t.operands[1 - side], by.integer * factor);
        const std::string name = fixed_name(program_, rule_, t);
        if (name.empty()) return false;
        const std::int64_t sum = form_.parts[name] += factor;
        if (sum == 0) form_.parts.erase(name);
        return small(sum, kLargestFactor);
    }
    LinearForm take() { return std::move(form_); }

  private:
    static bool small(std::int64_t value, std::int64_t largest) { return value > -largest && value < largest; }
    bool rest(std::int64_t value, std::int64_t factor) {
        if (factor != 1 && factor != -1 && !small(value, kLargestFactor)) return false;
        form_.rest += value * factor;
        return small(form_.rest, Differences::kLargest);
    }

    const Program& program_;
    const Rule& rule_;
    LinearForm form_;
};

}  // namespace

std::optional<double> literal(const Term& t) {
    if (t.op == Op::String) return 0;
    if (t.op == Op::Float) return t.real;
    // Above this a double does not hold every int.
    if (t.op == Op::Int && (t.integer >= Differences::kLargest || t.integer <= -Differences::kLargest)) return std::nullopt;
    if (t.op == Op::Int || t.op == Op::Bool || t.op == Op::Node) return static_cast<double>(t.integer);
    if (t.op == Op::ToFloat) return literal(t.operands[0]);
    if (t.op != Op::Negate) return std::nullopt;
    const auto value = literal(t.operands[0]);
    return value ? std::optional(-*value) : std::nullopt;
}

std::string fixed_name(const Program& program, const Rule& rule, const Term& side) {
    const Term& term = side.op == Op::ToFloat ? side.operands[0] : side;
    bool fixed = true;
    each_subterm(term, [&](const Term& t) {
        const bool arithmetic = t.op >= Op::Negate && t.op <= Op::Power && t.op != Op::Not;
        fixed =
            fixed && (t.is_variable() || t.op == Op::Constant || t.op == Op::Int || t.op == Op::Float || t.op == Op::String || arithmetic);
    });
    if (!fixed) return "";
    std::string text = print(program, rule, term);
    // As X / 2 is written of ints and of floats.
    if (!term.is_variable()) text += " " + type_name(term.type);
    // Two variables may have one name.
    each_variable(term, [&](VariableId v) { text += " " + std::to_string(v.index()); });
    return text;
}

std::optional<LinearForm> linear_form(const Program& program, const Rule& rule, const Term& t) {
    Adder adder(program, rule);
    return adder.add(t, 1) ? std::optional(adder.take()) : std::nullopt;
}

std::optional<LinearForm> linear_form(const Program& program, const Rule& rule, const Term& a, const Term& b) {
    Adder adder(program, rule);
    return adder.add(a, 1) && adder.add(b, -1) ? std::optional(adder.take()) : std::nullopt;
}

}  // namespace meld::lint
