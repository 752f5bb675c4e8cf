#include "compiler/check/analysis/rounds.h"

#include <algorithm>
#include <map>
#include <utility>

namespace meld::check {

namespace {

// A variable and a number that is added to it; without a variable it is something else.
struct Sum {
    VariableId variable;
    std::int64_t offset = 0;
};

Sum plain_sum(const Term& t) {
    if (t.is_variable()) return {t.variable, 0};
    if ((t.op != Op::Add && t.op != Op::Subtract) || t.operands.size() != 2) return {};
    const Term &left = t.operands[0], &right = t.operands[1];
    if (left.is_variable() && right.op == Op::Int) return {left.variable, t.op == Op::Add ? right.integer : -right.integer};
    if (t.op == Op::Add && right.is_variable() && left.op == Op::Int) return {right.variable, left.integer};
    return {};
}

// R, R + 1, or N where N = R + 1 stands in the body.
Sum sum(const Rule& rule, const Term& t) {
    const Sum out = plain_sum(t);
    for (const Clause& c : rule.body) {
        if (!out.variable.valid() || c.kind != Clause::Kind::Test || c.test.op != Op::Equal) continue;
        for (const std::size_t side : {0u, 1u}) {
            const Term& value = c.test.operands[1 - side];
            if (!c.test.operands[side].is_variable() || c.test.operands[side].variable != out.variable || value.is_variable()) continue;
            if (const Sum more = plain_sum(value); more.variable.valid()) return {more.variable, more.offset + out.offset};
        }
    }
    return out;
}

// One choice of the argument that counts, for each predicate.
using Counts = std::map<PredicateId, std::size_t>;

class Counter {
  public:
    Counter(const Program& program, const Stratum& stratum, const Counts& counts) : program_(program), stratum_(stratum), counts_(counts) {}

    Rounds run() {
        for (const RuleId id : stratum_.rules)
            if (!rule(program_.rules[id])) return Rounds::None;
        if (has_cycle(same_round_)) return Rounds::None;
        return has_cycle(unbounded_) ? Rounds::Endless : Rounds::Bounded;
    }

  private:
    using Reads = std::map<PredicateId, std::vector<PredicateId>>;

    // Notes what the head reads of the same round, and what it reads of unbounded rounds; false: the number may become less, or what
    // becomes of it is not known.
    bool rule(const Rule& rule) {
        const Atom& head = rule.heads[0].atom;
        const Sum now = sum(rule, head.arguments[counts_.at(head.predicate)]);
        std::vector<PredicateId> reads;
        bool known = true;
        each_atom(rule.body, [&](const Atom& a, bool) {
            if (!stratum_.contains(a.predicate)) return;
            const Sum before = sum(rule, a.arguments[counts_.at(a.predicate)]);
            known = known && before.variable.valid() && before.variable == now.variable && before.offset <= now.offset;
            if (known && before.offset == now.offset) same_round_[head.predicate].push_back(a.predicate);
            reads.push_back(a.predicate);
        });
        if (!known) return false;
        if (!reads.empty() && !is_bounded(rule, now.variable))
            for (const PredicateId p : reads) unbounded_[head.predicate].push_back(p);
        return true;
    }

    // The variables whose values the stratum computes.
    Variables computed(const Rule& rule) const {
        Variables out;
        const auto any = [&](const Clause& c) {
            bool found = false;
            each_variable(c, [&](VariableId v) { found = found || out.contains(v); });
            return found;
        };
        for (std::size_t size = 0, before = 1; size != before;) {
            before = out.size();
            for (const Clause& c : rule.body) {
                bool of_stratum = c.kind == Clause::Kind::Atom && stratum_.contains(c.atom.predicate);
                each_atom(c.inner, [&](const Atom& a, bool) { of_stratum = of_stratum || stratum_.contains(a.predicate); });
                const bool passes_on = c.kind != Clause::Kind::Atom && c.kind != Clause::Kind::Not &&
                                       (c.kind != Clause::Kind::Test || c.test.op == Op::Equal) && any(c);
                if (of_stratum || passes_on) each_variable(c, [&](VariableId v) { out.insert(v); });
            }
            size = out.size();
        }
        return out;
    }

    // R < 9, not R > 9; or R is in a fact that the stratum does not derive.
    bool is_bounded(const Rule& rule, VariableId round) const {
        const Variables inside = computed(rule);
        const auto below = [&](const auto& self, const Term& test) -> bool {
            if (test.op == Op::And) return self(self, test.operands[0]) || self(self, test.operands[1]);
            const bool less = test.op == Op::Less || test.op == Op::LessEqual;
            if (!less && test.op != Op::Greater && test.op != Op::GreaterEqual) return false;
            if (sum(rule, test.operands[less ? 0 : 1]).variable != round) return false;
            bool from_outside = true;
            each_variable(test.operands[less ? 1 : 0], [&](VariableId v) { from_outside = from_outside && !inside.contains(v); });
            return from_outside;
        };
        return std::ranges::any_of(rule.body, [&](const Clause& c) {
            if (c.kind == Clause::Kind::Test) return below(below, c.test);
            return c.kind == Clause::Kind::Atom && !stratum_.contains(c.atom.predicate) &&
                   std::any_of(c.atom.arguments.begin() + 1, c.atom.arguments.end(),
                               [&](const Term& t) { return sum(rule, t).variable == round; });
        });
    }

    // Whether a predicate is reached from itself.
    static bool has_cycle(const Reads& reads) {
        return std::ranges::any_of(reads, [&](const auto& from) {
            std::vector<PredicateId> todo = from.second;
            for (std::size_t i = 0; i < todo.size(); ++i) {
                if (todo[i] == from.first) return true;
                const auto found = reads.find(todo[i]);
                if (found == reads.end()) continue;
                for (const PredicateId next : found->second)
                    if (std::ranges::find(todo, next) == todo.end()) todo.push_back(next);
            }
            return false;
        });
    }

    const Program& program_;
    const Stratum& stratum_;
    const Counts& counts_;
    Reads same_round_, unbounded_;
};

// The ints in the group of a predicate, by their place.
std::vector<std::size_t> ints_of(const Predicate& p) {
    std::vector<std::size_t> ints;
    const std::size_t end = p.aggregate == Aggregate::None ? p.arguments.size() : p.aggregate_at;
    for (std::size_t i = 1; i < end; ++i)
        if (p.arguments[i].type == Type::Int) ints.push_back(i);
    return ints;
}

// More choices than this are not tried.
constexpr std::size_t kMaxChoices = 512;

}  // namespace

Rounds count_rounds(const Program& program, const Stratum& stratum) {
    std::size_t choices = 1;
    for (const PredicateId p : stratum.predicates) choices = std::min(choices * ints_of(program.predicates[p]).size(), kMaxChoices);
    Rounds best = Rounds::None;
    // The first ints first: a program mostly counts there.
    for (std::size_t choice = 0; choice < choices && best != Rounds::Bounded; ++choice) {
        Counts counts;
        std::size_t rest = choice;
        for (const PredicateId p : stratum.predicates) {
            const std::vector<std::size_t> ints = ints_of(program.predicates[p]);
            counts[p] = ints[rest % ints.size()];
            rest /= ints.size();
        }
        best = std::max(best, Counter(program, stratum, counts).run());
    }
    return best;
}

}  // namespace meld::check
