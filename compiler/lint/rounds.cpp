#include "compiler/lint/rounds.h"

#include <algorithm>
#include <map>

namespace meld::lint {

using namespace check;

namespace {

// A variable and a number that is added to it; without a variable it is something else.
struct Sum {
    VariableId variable;
    std::int64_t offset = 0;
};

class Counter {
  public:
    Counter(const Program& program, const check::Stratum& stratum) : program_(program), stratum_(stratum) {}

    Rounds run() {
        for (const RuleId id : stratum_.rules)
            if (!rule(program_.rules[id])) return Rounds::None;
        for (const PredicateId p : stratum_.predicates)
            if (same_round(p, p)) return Rounds::None;
        return bounded_ ? Rounds::Bounded : Rounds::Endless;
    }

  private:
    // The argument that may be the number of the round; 0: none.
    std::size_t round_of(PredicateId id) const {
        const Predicate& p = program_.predicates[id];
        const std::size_t end = p.aggregate == Aggregate::None ? p.arguments.size() : p.aggregate_at;
        for (std::size_t i = 1; i < end; ++i)
            if (p.arguments[i].type == Type::Int) return i;
        return 0;
    }

    // Notes what the head reads of the same round; false: the number may become less, or what becomes of it is not known.
    bool rule(const Rule& rule) {
        const Atom& head = rule.heads[0].atom;
        bool known = true;
        std::vector<VariableId> rounds;
        each_atom(rule.body, [&](const Atom& a, bool) {
            if (!stratum_.contains(a.predicate)) return;
            const std::size_t from = round_of(a.predicate), to = round_of(head.predicate);
            const Sum before = from ? sum(rule, a.arguments[from]) : Sum(), now = to ? sum(rule, head.arguments[to]) : Sum();
            known = known && before.variable.valid() && before.variable == now.variable && before.offset <= now.offset;
            if (!known) return;
            if (before.offset == now.offset) reads_[head.predicate].push_back(a.predicate);
            rounds.push_back(before.variable);
        });
        for (const Clause& c : rule.body) {
            if (c.kind != Clause::Kind::Test || c.test.op < Op::Less || c.test.op > Op::GreaterEqual) continue;
            // R < 9, not R > 9.
            const bool less = c.test.op == Op::Less || c.test.op == Op::LessEqual;
            const Term& low = c.test.operands[less ? 0 : 1];
            bounded_ = bounded_ || std::find(rounds.begin(), rounds.end(), sum(rule, low).variable) != rounds.end();
        }
        return known;
    }
    // R, R + 1, or N where N = R + 1 stands in the body.
    static Sum sum(const Rule& rule, const Term& t) {
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
    static Sum plain_sum(const Term& t) {
        if (t.is_variable()) return {t.variable, 0};
        if ((t.op != Op::Add && t.op != Op::Subtract) || t.operands.size() != 2) return {};
        const Term &left = t.operands[0], &right = t.operands[1];
        if (left.is_variable() && right.op == Op::Int) return {left.variable, t.op == Op::Add ? right.integer : -right.integer};
        if (t.op == Op::Add && right.is_variable() && left.op == Op::Int) return {right.variable, left.integer};
        return {};
    }
    // Whether the one is reached from the other within a round.
    bool same_round(PredicateId goal, PredicateId from) const {
        std::vector<PredicateId> todo{from};
        for (std::size_t i = 0; i < todo.size(); ++i) {
            const auto found = reads_.find(todo[i]);
            if (found == reads_.end()) continue;
            for (const PredicateId next : found->second) {
                if (next == goal) return true;
                if (std::find(todo.begin(), todo.end(), next) == todo.end()) todo.push_back(next);
            }
        }
        return false;
    }

    const Program& program_;
    const check::Stratum& stratum_;
    std::map<PredicateId, std::vector<PredicateId>> reads_;  // In the same round.
    bool bounded_ = false;
};

}  // namespace

Rounds count_rounds(const Program& program, const check::Stratum& stratum) { return Counter(program, stratum).run(); }

}  // namespace meld::lint
