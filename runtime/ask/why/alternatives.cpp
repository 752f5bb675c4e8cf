#include "runtime/ask/why/alternatives.h"

#include <fmt/format.h>

#include <set>
#include <utility>

namespace meld::inspect {

using check::Rule;

namespace {

constexpr std::size_t kMost = 3;

}  // namespace

Result<std::vector<std::string>> alternatives(Explainer& e, const Known& fact) {
    const check::Predicate& p = e.predicate(fact.predicate);
    if (p.aggregate == check::Aggregate::None) return std::vector<std::string>{};
    Known group = fact;
    for (std::size_t a = p.aggregate_at - 1; a < group.arguments.size(); ++a) group.arguments[a].reset();
    std::set<std::string> seen{e.text(fact)};
    std::vector<std::string> out;
    for (const Rule* rule : e.views(fact.predicate)) {
        const std::optional<PartialMatch> match = e.match_head(*rule, rule->heads[0].atom, group, false);
        if (!match || !e.cannot(match->body).empty()) continue;
        const Explainer::Search search{.age = fact.age};
        const Result<bool> done = e.search(*match, search, [&](const Solution& solution) {
            Known other = fact;
            Values values = solution.values;
            for (std::size_t a = p.aggregate_at - 1; a < other.arguments.size(); ++a) {
                const check::Term& term = rule->heads[0].atom.arguments[a + 1];
                other.arguments[a] = e.terms().value_as(term, p.arguments[a + 1].type, values);
                if (!e.terms().scratch.went_well()) return true;
            }
            // A better one has come since the catom has read: it has not lost.
            const std::size_t at = p.aggregate_at - 1;
            const int order = tuple::compare(e.terms().types.of(p.arguments[at + 1].type), *other.arguments[at], *fact.arguments[at]);
            if (syntax::keeps_least(p.aggregate) ? order < 0 : syntax::keeps_greatest(p.aggregate) && order > 0) return true;
            const std::string text = e.text(other);
            if (!seen.insert(text).second || out.size() == kMost) return true;
            const Rule named = e.named(*match, solution.values, bound_by(*match));
            out.push_back(fmt::format("{}: {}:{} with {}", text, rule->file, rule->line, e.print(named, rule->body)));
            return true;
        });
        if (!done) return tl::unexpected<Error>(done.error());
    }
    if (const std::size_t more = seen.size() - 1 - out.size(); more > 0)
        out.push_back(fmt::format("{} more value{}", more, more == 1 ? "" : "s"));
    return out;
}

}  // namespace meld::inspect
