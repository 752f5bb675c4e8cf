#include "runtime/ask/why/delayed_derivations.h"

#include <algorithm>
#include <vector>

namespace meld::inspect {

using check::Clause;
using check::VariableId;

namespace {

bool waits(const PartialMatch& match) { return match.of->heads[0].delay.op != check::Op::Anonymous; }

// What a way binds of the head.
Bound told_apart_by(const Explainer& e, const PartialMatch& match) {
    const Bound known = bound_by(match);
    Bound out = match.bound;
    const auto keep = [&](VariableId v) { out[v.index()] = known[v.index()]; };
    const check::Atom& head = match.of->heads[0].atom;
    const check::Predicate& p = e.predicate(head.predicate);
    for (std::size_t a = 0; a < head.arguments.size(); ++a) {
        // What is counted is not computed.
        if (p.aggregate == check::Aggregate::Count && a == p.aggregate_at) continue;
        check::each_variable(head.arguments[a], keep);
    }
    return out;
}

}  // namespace

void tell_apart(PartialMatch& match) {
    if (!waits(match)) return;
    for (Clause& c : match.body)
        if (c.kind == Clause::Kind::Element && !c.position.valid()) c.position = match.rule.variables.add({"_", c.span, check::Type::Int});
    match.values.resize(match.rule.variables.count());
    match.bound.resize(match.rule.variables.count());
}

Result<std::optional<bool>> delay_has_passed(Explainer& explainer, const PartialMatch& match, const Explainer::Search& search,
                                             const Solution& solution) {
    if (!waits(match)) return true;
    Values values = solution.values;
    const i64 ticks = explainer.terms().value(match.of->heads[0].delay, values).integer;
    PartialMatch same = match;
    same.values = solution.values;
    same.bound = told_apart_by(explainer, match);
    std::vector<std::optional<Known>> facts;
    for (std::size_t c = 0; c < solution.facts.size(); ++c) {
        facts.emplace_back();
        if (solution.facts[c] != nullptr) facts[c] = explainer.keep(same.body[c].atom.predicate, *solution.facts[c], 0);
    }
    const auto as_before = [&](const Clause& clause, const Fact& fact) {
        const std::optional<Known>& before = facts[static_cast<std::size_t>(&clause - same.body.data())];
        if (!before) return true;
        bool equal = before->catom == fact.catom;
        const check::Predicate& p = explainer.predicate(clause.atom.predicate);
        for (std::size_t a = 0; equal && a < before->arguments.size(); ++a)
            equal = explainer.terms().equal(p.arguments[a + 1].type, fact.arguments[a], *before->arguments[a]);
        return equal;
    };
    const States& states = explainer.states();
    for (i64 back = 1; back <= ticks; ++back) {
        Explainer::Search earlier = search;
        earlier.age += static_cast<std::size_t>(back);
        earlier.allowed = as_before;
        // Nothing is evaluated before the first tick.
        if (states.first_tick == 0 && states.tick - static_cast<i64>(earlier.age) < 1) return false;
        bool met = false;
        const Result<bool> done = explainer.search(same, earlier, [&](const Solution& found) {
            met = std::ranges::all_of(same.body, [&](const Clause& c) {
                return c.kind != Clause::Kind::Element ||
                       found.values[c.position.index()].integer == solution.values[c.position.index()].integer;
            });
            return !met;
        });
        if (!done) return tl::unexpected<Error>(done.error());
        if (!*done) return std::nullopt;
        if (!met) return false;
    }
    return true;
}

}  // namespace meld::inspect
