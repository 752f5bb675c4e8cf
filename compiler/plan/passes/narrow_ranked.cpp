// Pass: ranked. Finds bounds of ints that grow with the ranks of their facts, which have a maximum:
//     dist(A, 0) :- source(A).      dist(B, D + 1) :- neighbor(A, B), dist(A, D).          0 <= D <= 2^30
// A derived fact has a rank above those of all facts of its stratum in the body. So if each rule of a stratum either derives a value of a
// known range, or adds at most a constant to a value that it reads in the stratum, a value is at most that constant times the rank away
// from that range. Assumes that the strata are final.
#include <algorithm>
#include <optional>
#include <set>

#include "compiler/plan/passes/ranges.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

// An argument of a predicate of the stratum.
using Place = std::pair<PredicateId, std::size_t>;

// What a rule gives an argument: a value in a range, or in that range from the value of another argument of the stratum.
struct Given {
    Place to = {};
    std::optional<Place> from = {};
    Range range = {};
};

// A term as a variable and the range of what is added to it.
struct Shifted {
    VariableId variable = {};
    Range by = {0, 0};
};
std::optional<Shifted> shifted(const Term& t, const KnownRanges& known) {
    if (t.is_variable()) return Shifted{.variable = t.variable};
    if (t.op != Op::Add && t.op != Op::Subtract) return std::nullopt;
    for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
        const Range other = range_of(t.operands[1 - i], known);
        if (!other.is_bounded() || (t.op == Op::Subtract && i == 1)) continue;
        std::optional<Shifted> inner = shifted(t.operands[i], known);
        if (!inner) continue;
        inner->by = sum(inner->by, t.op == Op::Add ? other : negative(other));
        return inner;
    }
    return std::nullopt;
}

class Bounds {
  public:
    Bounds(Program& program, const check::Stratum& stratum) : program_(program), stratum_(stratum) {}

    void run() {
        for (const PredicateId p : stratum_.predicates)
            for (std::size_t i = 1; i < program_.predicates[p].arguments.size(); ++i)
                if (program_.predicates[p].arguments[i].type == Type::Int) places_.insert({p, i});
        for (const RuleId id : stratum_.rules) study(program_.rules[id]);
        drop_unknown();
        if (places_.empty()) return;
        Range start = Range::empty(), step = {0, 0};
        for (const Given& given : all_) {
            if (!places_.contains(given.to)) continue;
            (given.from ? step : start) = either(given.from ? step : start, given.range);
        }
        if (!start.is_bounded() || !step.is_bounded()) return;
        // No rank is higher; where the sums overflow there is no bound.
        constexpr std::int64_t most = INT32_MAX;
        if (std::max({start.greatest, -start.least, step.greatest, -step.least}) > most) return;
        const Range bound{start.least + step.least * kMaxRank, start.greatest + step.greatest * kMaxRank};
        for (const auto& [p, i] : places_) {
            Argument& a = program_.predicates[p].arguments[i];
            a.least = std::max(a.least, bound.least);
            a.greatest = std::min(a.greatest, bound.greatest);
        }
    }

  private:
    void study(const Rule& rule) {
        KnownRanges known;
        const auto range = [&](PredicateId p, std::size_t i) {
            const Argument& a = program_.predicates[p].arguments[i];
            return Range{a.least, a.greatest};
        };
        if (!understand(program_, rule, range, known)) return;
        const Atom& head = rule.heads[0].atom;
        for (std::size_t i = 1; i < head.arguments.size(); ++i) {
            const Place to{head.predicate, i};
            if (!places_.contains(to)) continue;
            if (const Range value = range_of(head.arguments[i], known); value.is_bounded()) {
                all_.push_back({.to = to, .range = value});
                continue;
            }
            const std::optional<Shifted> term = shifted(head.arguments[i], known);
            const std::optional<Place> from = term ? read_as(rule, term->variable) : std::nullopt;
            all_.push_back({.to = to, .from = from, .range = from ? term->by : Range{}});
        }
    }

    // An argument of the stratum that the variable is in a fact which every derivation by the rule rests on.
    std::optional<Place> read_as(const Rule& rule, VariableId variable) const {
        for (const Clause& c : rule.body) {
            if (c.kind != Clause::Kind::Atom || !stratum_.contains(c.atom.predicate)) continue;
            for (std::size_t i = 1; i < c.atom.arguments.size(); ++i)
                if (c.atom.arguments[i].is_variable() && c.atom.arguments[i].variable == variable) return Place{c.atom.predicate, i};
        }
        return std::nullopt;
    }

    // Of an argument that some rule gives an unknown value nothing is known, nor of those that take theirs from it.
    void drop_unknown() {
        for (const PredicateId p : stratum_.predicates) {
            const Predicate& predicate = program_.predicates[p];
            // Only derivations give values, and what is kept is the value of one of them.
            const bool plain = predicate.kind == PredicateKind::Persistent && predicate.world == WorldSource::None && !predicate.sensed &&
                               (predicate.aggregate == Aggregate::None || keeps_best(predicate.aggregate));
            if (!plain) std::erase_if(places_, [&](const Place& place) { return place.first == p; });
        }
        for (bool dropped = true; dropped;) {
            dropped = false;
            for (const Given& given : all_) {
                const bool known = given.from ? places_.contains(*given.from) && given.range.is_bounded() : given.range.is_bounded();
                dropped = (!known && places_.erase(given.to) > 0) || dropped;
            }
        }
    }

    Program& program_;
    const check::Stratum& stratum_;
    std::set<Place> places_;
    std::vector<Given> all_;
};

}  // namespace

void narrow_ranked(Program& program) {
    for (const check::Stratum& stratum : program.strata)
        if (has_ranks(program, stratum)) Bounds(program, stratum).run();
}

}  // namespace meld::plan
