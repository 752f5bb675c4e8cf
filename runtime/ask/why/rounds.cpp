#include "runtime/ask/why/rounds.h"

#include <algorithm>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

namespace meld::inspect {

using check::Clause;
using check::PredicateId;
using check::Rule;

namespace {

// A computation from nothing, forwards: each round derives from the facts that the last one has added, so that each derivation is met once
// for every fact of the recursion in it, however many rounds there are.
class FromNothing {
  public:
    FromNothing(Explainer& e, const check::Stratum& recursion, u64 catom, std::size_t age, Rounds::ByFact& rounds)
        : e_(e), recursion_(recursion), catom_(catom), age_(age), rounds_(rounds) {}

    void run() {
        for (const PredicateId p : recursion_.predicates)
            e_.facts(age_).at(e_.program().source(p), catom_, [&](const Fact& f) {
                const Known fact = e_.keep(p, f, age_);
                left_.emplace(e_.text(fact), fact);
                return true;
            });
        for (const auto& [text, fact] : left_)
            if (e_.is_base(fact)) came_.insert(text);
        each_rule([&](const Rule& rule) {
            const bool inside = std::ranges::any_of(rule.body, [&](const Clause& c) { return recurs(c); });
            Known head{.predicate = rule.heads[0].atom.predicate, .catom = catom_, .age = age_};
            head.arguments.resize(rule.heads[0].atom.arguments.size() - 1);
            if (!inside) derive(rule, e_.match_head(rule, rule.heads[0].atom, head, false));
        });
        for (std::size_t round = 1; !came_.empty(); ++round) {
            std::vector<Known> last;
            for (const std::string& text : std::exchange(came_, {})) {
                const auto fact = left_.find(text);
                last.push_back(std::move(fact->second));
                left_.erase(fact);
                rounds_.emplace(text, round);
            }
            if (left_.empty()) return;
            each_rule([&](const Rule& rule) {
                for (const Clause& c : rule.body)
                    for (const Known& fact : last)
                        if (recurs(c) && c.atom.predicate == fact.predicate) derive(rule, e_.match_head(rule, c.atom, fact, false));
            });
        }
    }

  private:
    bool recurs(const Clause& c) const { return c.kind == Clause::Kind::Atom && recursion_.contains(c.atom.predicate); }
    template <class Visit>
    void each_rule(const Visit& visit) {
        for (const PredicateId p : recursion_.predicates)
            for (const Rule* rule : e_.views(p)) visit(*rule);
    }

    // Everything that follows in this way from the facts of the rounds before, and has not come yet.
    void derive(const Rule& rule, const std::optional<PartialMatch>& match) {
        if (!match || !e_.cannot(match->body).empty()) return;
        const auto known_before = [&](const Clause& c, const Fact& f) {
            return !recursion_.contains(c.atom.predicate) || rounds_.contains(e_.text(e_.keep(c.atom.predicate, f, age_)));
        };
        const auto found = [&](const Solution& solution) {
            note(rule, solution.values);
            return true;
        };
        // What came over links may have changed since it was read.
        const bool far = std::ranges::any_of(
            match->body, [&](const Clause& c) { return c.kind == Clause::Kind::Atom && e_.age_of(*match, c, true) > 0; });
        for (const bool spread : {false, true})
            if (!spread || far) static_cast<void>(e_.search(*match, {.age = age_, .spread = spread, .allowed = known_before}, found));
    }
    // The fact that a rule derives with these values; all that it may be, if it is computed from what is not known any more.
    void note(const Rule& rule, Values values) {
        const check::Atom& head = rule.heads[0].atom;
        Known fact{.predicate = head.predicate, .catom = catom_, .age = age_};
        for (std::size_t i = 1; i < head.arguments.size(); ++i) {
            const check::Term& term = head.arguments[i];
            if (!cannot(e_.checked(), term).empty()) {
                fact.arguments.emplace_back();
                continue;
            }
            const Value value = e_.terms().value_as(term, e_.predicate(head.predicate).arguments[i].type, values);
            if (!e_.terms().scratch.went_well()) return;
            fact.arguments.emplace_back(value);
        }
        if (fact.whole()) {
            const std::string text = e_.text(fact);
            if (left_.contains(text)) came_.insert(text);
            // Otherwise it does not hold, or a float in it is -0.0 and written as 0.0.
            const auto exact = [](const check::Argument& a) { return a.type != check::Type::Float && !a.type.compound(); };
            const bool as_written = std::ranges::all_of(e_.predicate(head.predicate).arguments, exact);
            if (as_written || left_.contains(text) || rounds_.contains(text)) return;
        }
        for (const auto& [text, other] : left_)
            if (fits(fact, other)) came_.insert(text);
    }
    bool fits(const Known& open, const Known& fact) {
        if (open.predicate != fact.predicate) return false;
        for (std::size_t i = 0; i < open.arguments.size(); ++i)
            if (open.arguments[i] &&
                !e_.terms().equal(e_.predicate(open.predicate).arguments[i + 1].type, *open.arguments[i], *fact.arguments[i]))
                return false;
        return true;
    }

    Explainer& e_;
    const check::Stratum& recursion_;
    const u64 catom_;
    const std::size_t age_;
    Rounds::ByFact& rounds_;
    std::unordered_map<std::string, Known> left_;  // What holds and is in no round yet, by its text.
    std::set<std::string> came_;                   // In this round.
};

}  // namespace

const Rounds::ByFact& Rounds::of(const check::Stratum& recursion, u64 catom, std::size_t age) {
    const auto [known, is_new] = known_.try_emplace({&recursion, catom, age});
    if (is_new) FromNothing(e_, recursion, catom, age, known->second).run();
    return known->second;
}

}  // namespace meld::inspect
