// Pass: narrow integers. Finds bounds of the int arguments of derived predicates that hold for any input of the run:
//     level(A, 0) :- top(A).      level(B, L + 1) :- neighbor(A, B), level(A, L), L < 20.          0 <= L <= 20
// The layout then stores them in 1, 2 or 4 bytes if that makes a record or a row smaller. Nothing is assumed about facts that the world or
// linear rules give, about sums, or about constants, which a run may set. Assumes that given facts are separate. Works stratum by stratum:
// the ranges that a stratum reads from earlier ones are final.
#include <algorithm>
#include <cstdint>
#include <limits>

#include "compiler/plan/passes/ranges.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

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
            KnownRanges known;
            if (!understand(program_, rule, [&](PredicateId q, std::size_t i) { return of(q)[i]; }, known)) continue;
            for (std::size_t i = 1; i < head.arguments.size(); ++i)
                made[i] = either(made[i], unchecked(p, i) ? Range{} : range_of(head.arguments[i], known));
        }
        return next;
    }
    // Folded, counted, timed and program-chosen values are not analysed.
    static bool unchecked(const Predicate& p, std::size_t argument) {
        return p.aggregate != Aggregate::None && !keeps_best(p.aggregate) && argument >= p.aggregate_at;
    }

    Program& program_;
    std::vector<std::vector<Range>> ranges_;
};

}  // namespace

void narrow_integers(Program& program) { Narrower(program).run(); }

}  // namespace meld::plan
