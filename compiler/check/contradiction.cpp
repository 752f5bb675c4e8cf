// Looks for conditions that cannot all be true: keeps between which numbers each compared term lies, and how each pair of
// terms may compare. Only conditions that must hold are looked at, so what is inside negations and aggregates does not count.
#include "compiler/check/contradiction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace meld::check {

namespace {

// How two terms may compare, as bits.
constexpr unsigned kLess = 1, kEqual = 2, kGreater = 4;
unsigned ways(Op op) {
    switch (op) {
        case Op::Equal: return kEqual;
        case Op::NotEqual: return kLess | kGreater;
        case Op::Less: return kLess;
        case Op::LessEqual: return kLess | kEqual;
        case Op::Greater: return kGreater;
        default: return kGreater | kEqual;
    }
}
unsigned turned(unsigned way) { return (way & kEqual) | (way & kLess ? kGreater : 0) | (way & kGreater ? kLess : 0); }
bool compares(const Term& t) { return t.op >= Op::Equal && t.op <= Op::GreaterEqual; }

struct Range {
    double least = -std::numeric_limits<double>::infinity(), greatest = std::numeric_limits<double>::infinity();
    bool above = false, below = false;  // The ends themselves are out of it.
    const Term *least_from = nullptr, *greatest_from = nullptr;
};

class Conditions {
  public:
    Conditions(const Program& program, const Rule& rule) : program_(program), rule_(rule) {}

    std::optional<Contradiction> find() {
        for (const Clause& c : rule_.body)
            if (c.kind == Clause::Kind::Test) conjuncts(c.test);
        for (const Term* t : tests_) {
            if (const auto found = impossible(*t)) return found;
            learn(*t);
        }
        // What stands behind a condition may be what it cannot be true with.
        for (const Term* t : tests_)
            if (const auto found = impossible(*t)) return found;
        return std::nullopt;
    }

  private:
    void conjuncts(const Term& t) {
        if (t.op != Op::And) return tests_.push_back(&t);
        for (const Term& operand : t.operands) conjuncts(operand);
    }

    // Above this a double does not hold every int, and bounds would be wrong by one.
    static constexpr double kExact = 9007199254740992.0;
    static std::optional<double> literal(const Term& t) {
        std::optional<double> value;
        if (t.op == Op::Int || t.op == Op::Bool || t.op == Op::Node) value = static_cast<double>(t.integer);
        if (t.op == Op::Float) value = t.real;
        if (t.op == Op::Negate || t.op == Op::ToFloat) {
            value = literal(t.operands[0]);
            if (value && t.op == Op::Negate) value = -*value;
        }
        if (value && t.type != Type::Float && std::abs(*value) >= kExact) return std::nullopt;
        return value;
    }
    static const Term& without_conversion(const Term& t) { return t.op == Op::ToFloat ? t.operands[0] : t; }
    // The term's text where it has the same value wherever the rule has it; else empty. Two variables may have one name.
    std::string key(const Term& side) const {
        bool fixed = true;
        each_subterm(side, [&](const Term& t) {
            const bool arithmetic = t.op >= Op::Negate && t.op <= Op::Power && t.op != Op::Not;
            fixed = fixed && (t.is_variable() || t.op == Op::Constant || t.op == Op::Int || t.op == Op::Float || t.op == Op::String || arithmetic);
        });
        if (!fixed) return "";
        std::string text = print(program_, rule_, without_conversion(side));
        each_variable(side, [&](VariableId v) { text += " " + std::to_string(v.index()); });
        return text;
    }
    Range range(const Term& side) const {
        if (const auto value = literal(side)) return {.least = *value, .greatest = *value};
        const auto known = ranges_.find(key(side));
        return known == ranges_.end() ? Range() : known->second;
    }

    // Of numbers, `below` is less than `above`, or as much where `equal` will do: never so?
    static bool never_less(const Range& below, const Range& above, bool equal) {
        if (below.least != above.greatest) return below.least > above.greatest;
        return !equal || below.above || above.below;
    }
    static Contradiction because(const Term& test, const Term* with) { return {.test = &test, .with = with == &test ? nullptr : with}; }

    std::optional<Contradiction> impossible(const Term& t) const {
        if (t.op == Op::Bool) return t.integer == 0 ? std::optional(because(t, nullptr)) : std::nullopt;
        if (t.op == Op::And || t.op == Op::Or) {
            const auto first = impossible(t.operands[0]), second = impossible(t.operands[1]);
            if (t.op == Op::Or ? !first || !second : !first && !second) return std::nullopt;
            return because(t, first && first->with != nullptr ? first->with : second ? second->with : nullptr);
        }
        if (!compares(t)) return std::nullopt;
        if (const auto found = impossible_pair(t)) return found;
        const Range left = range(t.operands[0]), right = range(t.operands[1]);
        const bool equal = ways(t.op) & kEqual;
        const auto from = [&](const Range& below, const Range& above) { return because(t, below.least_from != nullptr ? below.least_from : above.greatest_from); };
        if (t.op == Op::NotEqual) {
            if (left.least == left.greatest && right.least == right.greatest && left.least == right.least) return from(left, right);
            return std::nullopt;
        }
        if (t.op != Op::Greater && t.op != Op::GreaterEqual && never_less(left, right, equal)) return from(left, right);
        if (t.op != Op::Less && t.op != Op::LessEqual && never_less(right, left, equal)) return from(right, left);
        return std::nullopt;
    }
    std::optional<Contradiction> impossible_pair(const Term& t) const {
        for (const std::size_t side : {0u, 1u})
            if (const auto known = texts_.find(key(t.operands[side])); t.operands[1 - side].op == Op::String && known != texts_.end())
                if ((known->second->operands[0].op == Op::String ? known->second->operands[0] : known->second->operands[1]).text != t.operands[1 - side].text && t.op == Op::Equal)
                    return because(t, known->second);
        const std::string left = key(t.operands[0]), right = key(t.operands[1]);
        if (left.empty() || right.empty()) return std::nullopt;
        if (left == right) return ways(t.op) & kEqual ? std::nullopt : std::optional(because(t, nullptr));
        const auto known = pairs_.find({std::min(left, right), std::max(left, right)});
        if (known == pairs_.end()) return std::nullopt;
        const unsigned way = left < right ? ways(t.op) : turned(ways(t.op));
        return (known->second.ways & way) == 0 ? std::optional(because(t, known->second.test)) : std::nullopt;
    }

    void learn(const Term& t) {
        if (!compares(t)) return;
        const std::string left = key(t.operands[0]), right = key(t.operands[1]);
        for (const std::size_t side : {0u, 1u}) {
            const std::string& name = side == 0 ? left : right;
            const Term& other = t.operands[1 - side];
            if (name.empty()) continue;
            if (other.op == Op::String && t.op == Op::Equal) texts_.emplace(name, &t);
            const unsigned way = side == 0 ? ways(t.op) : turned(ways(t.op));
            if (const auto value = literal(other)) narrow(ranges_[name], way, *value, t, without_conversion(t.operands[side]).type == Type::Int);
        }
        if (left.empty() || right.empty()) return;
        Pair& pair = pairs_.try_emplace({std::min(left, right), std::max(left, right)}, Pair{.test = &t}).first->second;
        const unsigned all = pair.ways & (left < right ? ways(t.op) : turned(ways(t.op)));
        if (all != pair.ways) pair = {.ways = all, .test = &t};
    }
    // The term compares so with the value. No int lies between 3 and 4.
    static void narrow(Range& r, unsigned way, double value, const Term& test, bool whole) {
        const bool equal = way & kEqual;
        if (!(way & kLess)) {
            const double least = !whole ? value : equal ? std::ceil(value) : std::floor(value) + 1;
            if (least > r.least || (least == r.least && !equal)) r.least = least, r.above = !whole && !equal, r.least_from = &test;
        }
        if (!(way & kGreater)) {
            const double greatest = !whole ? value : equal ? std::floor(value) : std::ceil(value) - 1;
            if (greatest < r.greatest || (greatest == r.greatest && !equal)) r.greatest = greatest, r.below = !whole && !equal, r.greatest_from = &test;
        }
    }

    struct Pair {
        unsigned ways = kLess | kEqual | kGreater;
        const Term* test = nullptr;  // The last that left out some.
    };

    const Program& program_;
    const Rule& rule_;
    std::vector<const Term*> tests_;
    std::map<std::string, Range> ranges_;                          // By the text of a term.
    std::map<std::string, const Term*> texts_;                     // The condition that makes it equal to a text.
    std::map<std::pair<std::string, std::string>, Pair> pairs_;    // By both texts in their order.
};

}  // namespace

std::optional<Contradiction> contradiction(const Program& program, const Rule& rule) { return Conditions(program, rule).find(); }

}  // namespace meld::check
