// Looks for conditions that cannot all be true: each becomes bounds of differences, and a condition is refuted if all its possible bounds
// are. Ints are exact; of floats and all other values only the order counts, so rounding need not be predicted.
#include "compiler/lint/contradiction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "compiler/check/program/operators.h"
#include "compiler/lint/differences.h"
#include "compiler/lint/linear_form.h"

namespace meld::lint {

using namespace check;

namespace {

using Reasons = Differences::Reasons;
using Bound = Differences::Bound;

void add_conjuncts(const Term& t, std::vector<Condition>& out) {
    if (t.op != Op::And) return out.push_back({&t});
    for (const Term& operand : t.operands) add_conjuncts(operand, out);
}

class Conditions {
  public:
    Conditions(const Program& program, const Rule& rule) : program_(program), rule_(rule) { zero_ = *known_.node("zero"); }

    std::optional<Contradiction> find(const std::vector<Condition>& around, const std::vector<Condition>& body) {
        for (const Condition& c : around) learn(*c.term, c.holds, {c.term});
        // A later condition may contradict this one, and rule out all but one way to satisfy it.
        for (int round = 0; round < kRounds; ++round) {
            changed_ = false;
            for (const Condition& c : body) {
                if (const auto with = refuted(*c.term, c.holds)) return because(c, *with);
                learn(*c.term, c.holds, {c.term});
            }
            for (const Condition& c : around) {
                if (const auto with = refuted(*c.term, c.holds)) return because_of_inner(c, *with, body);
                learn(*c.term, c.holds, {c.term});
            }
            if (!changed_) break;
        }
        return std::nullopt;
    }

  private:
    // Each may decide another one; more are not worth the time.
    static constexpr int kRounds = 8;

    static Contradiction because(const Condition& c, Reasons with) {
        std::erase(with, c.term);
        return {.test = c, .with = std::move(with)};
    }
    // The last of the body that has to do with it.
    static std::optional<Contradiction> because_of_inner(const Condition& around, Reasons with, const std::vector<Condition>& body) {
        with = joined(std::move(with), {around.term});
        for (auto c = body.rbegin(); c != body.rend(); ++c)
            if (std::find(with.begin(), with.end(), c->term) != with.end()) return because(*c, std::move(with));
        return std::nullopt;
    }

    // ---- terms as numbers of nodes

    // The number of a term that has the same value wherever the rule has it.
    std::optional<std::size_t> node_of(const Term& side) {
        if (const auto value = literal(side)) return literal_node(*value, side);
        const std::string name = fixed_name(program_, rule_, side);
        if (name.empty()) return std::nullopt;
        const auto node = known_.node((side.op == Op::ToFloat ? "float of " : "") + name);
        if (node && side.op == Op::ToFloat) bound_by_int(*node, side.operands[0]);
        return node;
    }
    // Literals lie in their order.
    struct Literal {
        std::size_t node;
        double number;
        std::string text;
    };
    std::optional<std::size_t> literal_node(double number, const Term& side) {
        const std::string text = side.op == Op::String ? side.text : "";
        std::vector<Literal>& all = literals_[side.type.kind];
        for (const Literal& l : all)
            if (l.number == number && l.text == text) return l.node;
        const auto node = known_.node(fmt::format("literal {} of {}", all.size(), type_name(side.type)));
        if (!node) return std::nullopt;
        for (const Literal& l : all) {
            const bool less = l.number < number || (l.number == number && l.text < text);
            known_.learn({less ? l.node : *node, less ? *node : l.node, -1}, {});
        }
        all.push_back({*node, number, text});
        return node;
    }
    // A float converted from an int is ordered like the int, as far as a double holds every int.
    void bound_by_int(std::size_t node, const Term& whole) {
        const auto form = linear_form(program_, rule_, whole);
        if (!form || form->parts.size() != 1 || form->parts.begin()->second != 1 || !known_.knows(form->parts.begin()->first)) return;
        const std::size_t of = *known_.node(form->parts.begin()->first);
        const auto most = known_.most(of, zero_), least = known_.most(zero_, of);
        if (most)
            if (const auto limit = exact_limit(most->first + form->rest)) note({node, *limit, 0}, most->second);
        if (least)
            if (const auto limit = exact_limit(form->rest - least->first)) note({*limit, node, 0}, least->second);
    }
    std::optional<std::size_t> exact_limit(std::int64_t value) {
        if (std::abs(value) >= Differences::kLargest) return std::nullopt;
        Term number;
        number.type = Type::Float;
        return literal_node(static_cast<double>(value), number);
    }

    // ---- comparisons as bounds: one of several ways holds, with all of its bounds

    using Way = std::vector<Bound>;
    using Ways = std::vector<Way>;
    // k (x - y) + c compares so with 0, for k > 0.
    static Ways whole_ways(Op op, std::size_t x, std::size_t y, std::int64_t k, std::int64_t c) {
        const std::int64_t floor = floor_div(-c, k), ceil = -floor_div(c, k);
        const Bound at_most{x, y, op == Op::Less ? ceil - 1 : floor}, at_least{y, x, op == Op::Greater ? -floor - 1 : -ceil};
        switch (op) {
            case Op::Less:
            case Op::LessEqual:
                return {Way{at_most}};
            case Op::Greater:
            case Op::GreaterEqual:
                return {Way{at_least}};
            // No int lies between the two: never equal, always different.
            case Op::Equal:
                return floor != ceil ? Ways{} : Ways{Way{at_most, at_least}};
            default:
                return floor != ceil ? Ways{Way{}} : Ways{Way{{x, y, floor - 1}}, Way{{y, x, -ceil - 1}}};
        }
    }
    static std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0); }
    static Ways ordered_ways(Op op, std::size_t x, std::size_t y) { return whole_ways(op, x, y, 1, 0); }

    // Everything known about a comparison, each part correct by itself; Ways{} if it cannot be true.
    std::vector<Ways> meanings(const Term& t, Op op) {
        const Term &left = t.operands[0], &right = t.operands[1];
        if (left.type == Type::Int && right.type == Type::Int) return whole_meanings(left, right, op);
        std::vector<Ways> result;
        for (const bool first : {true, false})
            if (const Term &side = first ? left : right, &other = first ? right : left; side.op == Op::ToFloat && !literal(side))
                if (const auto value = literal(other); value && std::abs(*value) < static_cast<double>(Differences::kLargest))
                    if (const auto ways = against_float(side.operands[0], first ? op : turned(op), *value)) result.push_back(*ways);
        const auto x = node_of(left), y = node_of(right);
        if (x && y) result.push_back(ordered_ways(op, *x, *y));
        return result;
    }
    std::vector<Ways> whole_meanings(const Term& left, const Term& right, Op op) {
        std::vector<Ways> result;
        const auto form = linear_form(program_, rule_, left, right);
        if (form)
            if (const auto ways = ways_of(*form, op)) result.push_back(*ways);
        if (form && form->simple()) return result;
        const std::string l = fixed_name(program_, rule_, left), r = fixed_name(program_, rule_, right);
        if (l.empty() || r.empty() || literal(left) || literal(right)) return result;
        const auto x = known_.node(l), y = known_.node(r);
        if (x && y) result.push_back(ordered_ways(op, *x, *y));
        return result;
    }
    // The form compares so with 0.
    std::optional<Ways> ways_of(const LinearForm& form, Op op) {
        if (form.parts.empty()) return whole_ways(op, zero_, zero_, 1, form.rest);
        std::int64_t k = form.parts.begin()->second;
        if (form.simple() && form.parts.size() == 2) {
            const auto x = known_.node(form.parts.begin()->first), y = known_.node(form.parts.rbegin()->first);
            if (!x || !y) return std::nullopt;
            return k > 0 ? whole_ways(op, *x, *y, k, form.rest) : whole_ways(op, *y, *x, -k, form.rest);
        }
        std::string name = form.parts.begin()->first;
        if (form.parts.size() > 1) {
            std::int64_t common = 0;
            for (const auto& [part, factor] : form.parts) common = std::gcd(common, factor);
            const std::int64_t sign = k > 0 ? common : -common;
            name = "sum";
            for (const auto& [part, factor] : form.parts) name += fmt::format(" + {} * ({})", factor / sign, part);
            k = sign;
        }
        const auto x = known_.node(name);
        if (!x) return std::nullopt;
        return k > 0 ? whole_ways(op, *x, zero_, k, form.rest) : whole_ways(op, zero_, *x, -k, form.rest);
    }
    // An int as a float compares so with this number: below kLargest as the int itself does.
    std::optional<Ways> against_float(const Term& whole, Op op, double value) {
        auto form = linear_form(program_, rule_, whole);
        if (!form) return std::nullopt;
        const double floor = std::floor(value);
        if (floor != value) {
            // Between floor and floor + 1.
            if (op == Op::Equal) return Ways{};
            if (op == Op::NotEqual) return std::nullopt;
            op = op == Op::Less || op == Op::LessEqual ? Op::LessEqual : Op::Greater;
        }
        form->rest -= static_cast<std::int64_t>(floor);
        return ways_of(*form, op);
    }

    // ---- conditions

    // The other conditions because of which this cannot be true; none if it needs no others.
    std::optional<Reasons> refuted(const Term& t, bool holds) {
        if (t.op == Op::Bool) return (t.integer != 0) == holds ? std::nullopt : std::optional(Reasons{});
        if (t.op == Op::Not) return refuted(t.operands[0], !holds);
        if (t.op == Op::And || t.op == Op::Or) {
            const auto first = refuted(t.operands[0], holds), second = refuted(t.operands[1], holds);
            if ((t.op == Op::And) == holds) return first ? first : second;
            return first && second ? std::optional(joined(*first, *second)) : std::nullopt;
        }
        if (!compares(t) || !decided(t, holds)) return std::nullopt;
        for (const Ways& ways : meanings(t, holds ? t.op : opposite(t.op)))
            if (const auto why = refuted(ways)) return why;
        return std::nullopt;
    }
    // For NaN both a comparison and its opposite are false.
    static bool decided(const Term& t, bool holds) { return holds || t.operands[0].type != Type::Float; }
    std::optional<Reasons> refuted(const Ways& ways) const {
        Reasons all;
        for (const Way& way : ways) {
            const auto why = refuted(way);
            if (!why) return std::nullopt;
            all = joined(std::move(all), *why);
        }
        return all;
    }
    std::optional<Reasons> refuted(const Way& way) const {
        for (const Bound& b : way)
            if (auto why = known_.refutes(b)) return why;
        return std::nullopt;
    }

    void learn(const Term& t, bool holds, const Reasons& why) {
        if (t.op == Op::Not) return learn(t.operands[0], !holds, why);
        if (t.op == Op::And || t.op == Op::Or) {
            if ((t.op == Op::And) == holds) {
                for (const Term& operand : t.operands) learn(operand, holds, why);
                return;
            }
            // If one of them cannot be true, the other is.
            for (const std::size_t side : {0u, 1u})
                if (const auto without = refuted(t.operands[side], holds)) return learn(t.operands[1 - side], holds, joined(*without, why));
            return;
        }
        if (!compares(t) || !decided(t, holds)) return;
        for (const Ways& ways : meanings(t, holds ? t.op : opposite(t.op))) learn(ways, why);
    }
    void learn(const Ways& ways, const Reasons& why) {
        const Way* only = nullptr;
        Reasons all = why;
        for (const Way& way : ways) {
            if (const auto without = refuted(way)) {
                all = joined(std::move(all), *without);
                continue;
            }
            if (only != nullptr) return;
            only = &way;
        }
        if (only == nullptr) return;
        for (const Bound& b : *only) note(b, all);
    }
    void note(const Bound& b, const Reasons& why) {
        if (!known_.refutes(b) && known_.learn(b, why)) changed_ = true;
    }

    const Program& program_;
    const Rule& rule_;
    Differences known_;
    std::size_t zero_ = 0;
    std::map<Type::Kind, std::vector<Literal>> literals_;
    bool changed_ = false;
};

}  // namespace

std::vector<Condition> conditions(const Term& term) {
    std::vector<Condition> result;
    add_conjuncts(term, result);
    return result;
}

std::vector<Condition> conditions(const std::vector<Clause>& body) {
    std::vector<Condition> result;
    for (const Clause& c : body)
        if (c.kind == Clause::Kind::Test) add_conjuncts(c.test, result);
    return result;
}

std::optional<Contradiction> contradiction(const Program& program, const Rule& rule, const std::vector<Condition>& around,
                                           const std::vector<Condition>& body) {
    return body.empty() ? std::nullopt : Conditions(program, rule).find(around, body);
}

}  // namespace meld::lint
