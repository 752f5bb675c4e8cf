// Pass: narrow integers. Finds bounds of the int arguments of derived predicates that hold for any input of the run:
//     level(A, 0) :- top(A).      level(B, L + 1) :- neighbor(A, B), level(A, L), L < 20.          0 <= L <= 20
// The layout then stores them in 1, 2 or 4 bytes if that makes a record or a row smaller. Nothing is assumed about facts that the world or
// linear rules give, about sums, or about constants, which a run may set. Assumes that given facts are separate. Works stratum by stratum:
// the ranges that a stratum reads from earlier ones are final.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>

#include "compiler/check/operators.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

// From least to greatest; empty where least is the greater: nothing has been derived yet.
struct Range {
    std::int64_t least = INT64_MIN, greatest = INT64_MAX;

    static Range empty() { return {INT64_MAX, INT64_MIN}; }
    bool is_empty() const { return least > greatest; }
    bool operator==(const Range&) const = default;
};
Range either(const Range& a, const Range& b) {
    if (a.is_empty()) return b;
    if (b.is_empty()) return a;
    return {std::min(a.least, b.least), std::max(a.greatest, b.greatest)};
}
Range both(const Range& a, const Range& b) { return {std::max(a.least, b.least), std::min(a.greatest, b.greatest)}; }

using Known = std::map<VariableId, Range>;

// The possible results of an operation. A value that overflows ends the run, so the range of stored values ends at the limits of ints.
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

Range range_of(const Term& t, const Known& known) {
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

class Narrower {
  public:
    explicit Narrower(Program& program) : program_(program), ranges_(program.predicates.count()) {
        std::vector<bool> derived(program.predicates.count(), false);
        for (const Rule& r : program.rules)
            if (!r.linear) derived[r.heads[0].atom.predicate.index()] = true;
        for (const PredicateId p : program.predicates.ids()) {
            const Predicate& predicate = program.predicates[p];
            const bool ours = is_ours(predicate) && derived[p.index()];
            of(p).assign(predicate.arguments.size(), ours ? Range::empty() : Range{});
            if (!ours) sense(predicate, of(p));
        }
    }

    void run() {
        find_strongly_connected(program_);
        for (const check::Stratum& c : program_.strata)
            if (!c.rules.empty()) solve(c);
        for (const PredicateId p : program_.predicates.ids())
            for (std::size_t i = 1; i < of(p).size(); ++i) {
                Argument& argument = program_.predicates[p].arguments[i];
                if (argument.type != Type::Int || of(p)[i].is_empty()) continue;
                MELD_ENSURE(of(p)[i].least <= of(p)[i].greatest);
                argument.least = of(p)[i].least;
                argument.greatest = of(p)[i].greatest;
            }
    }

  private:
    std::vector<Range>& of(PredicateId p) { return ranges_[p.index()]; }

    static bool is_ours(const Predicate& p) { return p.kind == PredicateKind::Persistent && p.world == WorldSource::None && !p.sensed; }

    void solve(const check::Stratum& c) {
        // Upwards until nothing grows; a range that still grows after a while may grow for ever.
        constexpr int kPatience = 4, kRefinements = 2;
        for (int round = 0;; ++round) {
            const std::vector<std::vector<Range>> next = derived(c);
            bool grew = false;
            for (std::size_t k = 0; k < next.size(); ++k)
                for (std::size_t i = 0; i < next[k].size(); ++i) {
                    Range& now = of(c.predicates[k])[i];
                    Range r = either(now, next[k][i]);
                    if (round >= kPatience && !now.is_empty()) {
                        if (r.least < now.least) r.least = INT64_MIN;
                        if (r.greatest > now.greatest) r.greatest = INT64_MAX;
                    }
                    grew = grew || r != now;
                    now = r;
                }
            if (!grew) break;
        }
        // And down again: a property of all facts in the ranges also holds for the facts that rules derive from them.
        for (int again = 0; again < kRefinements; ++again) {
            std::vector<std::vector<Range>> next = derived(c);
            for (std::size_t k = 0; k < next.size(); ++k) of(c.predicates[k]) = std::move(next[k]);
        }
    }

    void sense(const Predicate& p, std::vector<Range>& ranges) {
        if (p.world == WorldSource::Facts) {
            for (std::size_t i = 1; i < ranges.size(); ++i) {
                if (p.arguments[i].type != Type::Int) continue;
                ranges[i] = Range::empty();
                for (const Fact& f : p.facts) ranges[i] = either(ranges[i], {f.arguments[i - 1].integer, f.arguments[i - 1].integer});
            }
            return;
        }
        if (p.world == WorldSource::None) return;
        const SenseInfo& sense = info(p.world);
        MELD_EXPECT(ranges.size() == sense.arguments + 1, "{} has {} arguments", p.name, ranges.size());
        switch (sense.values) {
            case SenseInfo::Values::Any:
                break;
            case SenseInfo::Values::Port:
                ranges.back() = Range{0, most_ports() - 1};
                break;
            case SenseInfo::Values::PortCount:
                ranges.back() = Range{0, most_ports()};
                break;
        }
    }

    // As many as there are numbers for, where degrees have no bound.
    i64 most_ports() const { return program_.by_links ? i64{std::numeric_limits<std::int32_t>::max()} : i64{kMaxPorts}; }

    // The ranges of the facts that the rules of a stratum derive from facts in the present ranges, by predicate of the stratum.
    std::vector<std::vector<Range>> derived(const check::Stratum& c) {
        std::vector<std::vector<Range>> next;
        for (const PredicateId p : c.predicates) {
            next.push_back(of(p));
            if (is_ours(program_.predicates[p])) std::fill(next.back().begin(), next.back().end(), Range::empty());
        }
        for (const RuleId id : c.rules) {
            const Rule& rule = program_.rules[id];
            const Atom& head = rule.heads[0].atom;
            const Predicate& p = program_.predicates[head.predicate];
            if (!is_ours(p)) continue;
            const auto place = std::lower_bound(c.predicates.begin(), c.predicates.end(), head.predicate);
            std::vector<Range>& made = next[static_cast<std::size_t>(place - c.predicates.begin())];
            Known known;
            if (!understand(rule, known)) continue;
            for (std::size_t i = 1; i < head.arguments.size(); ++i)
                made[i] = either(made[i], unchecked(p, i) ? Range{} : range_of(head.arguments[i], known));
        }
        return next;
    }
    // Folded, counted, timed and program-chosen values are not analysed.
    static bool unchecked(const Predicate& p, std::size_t argument) {
        return p.aggregate != Aggregate::None && !keeps_best(p.aggregate) && argument >= p.aggregate_at;
    }

    // The ranges of a rule's variables; false: the body cannot hold yet.
    bool understand(const Rule& rule, Known& known) {
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
                        const Range& r = of(c.atom.predicate)[i];
                        const Type& type = program_.predicates[c.atom.predicate].arguments[i].type;
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

    Program& program_;
    std::vector<std::vector<Range>> ranges_;
};

}  // namespace

void narrow_integers(Program& program) { Narrower(program).run(); }

}  // namespace meld::plan
