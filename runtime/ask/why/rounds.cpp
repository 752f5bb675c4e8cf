#include "runtime/ask/why/rounds.h"

#include <utility>
#include <vector>

namespace meld::inspect {

using check::Clause;
using check::PredicateId;
using check::Rule;

const Rounds::ByFact& Rounds::of(const check::Stratum& recursion, u64 catom, std::size_t age) {
    const auto [known, is_new] = known_.try_emplace({&recursion, catom, age});
    ByFact& rounds = known->second;
    if (!is_new) return rounds;
    std::vector<Known> left;
    for (const PredicateId p : recursion.predicates)
        e_.facts(age).at(e_.program().source(p), catom, [&](const Fact& f) {
            left.push_back(e_.keep(p, f, age));
            return true;
        });
    for (std::size_t round = 1; !left.empty(); ++round) {
        std::vector<std::string> came;
        std::erase_if(left, [&](const Known& fact) {
            bool holds = false;
            for (const Rule* rule : e_.views(fact.predicate)) {
                const std::optional<PartialMatch> match = e_.match_head(*rule, rule->heads[0].atom, fact, false);
                if (holds || !match || !e_.cannot(match->body).empty()) continue;
                const auto known_before = [&](const Clause& c, const Fact& f) {
                    return !recursion.contains(c.atom.predicate) || rounds.contains(e_.text(e_.keep(c.atom.predicate, f, age)));
                };
                // What came over links may have changed since it was read.
                for (const bool spread : {false, true})
                    if (!holds)
                        static_cast<void>(e_.search(*match, {.age = age, .spread = spread, .allowed = known_before}, [&](const Solution&) {
                            holds = true;
                            return false;
                        }));
            }
            holds = holds || e_.is_base(fact);
            if (holds) came.push_back(e_.text(fact));
            return holds;
        });
        if (came.empty()) break;
        for (std::string& text : came) rounds.emplace(std::move(text), round);
    }
    return rounds;
}

}  // namespace meld::inspect
