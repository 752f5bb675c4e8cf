#include "runtime/ask/why/failure.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

namespace meld::inspect {

using check::Clause;

bool all_bound(const check::Term& term, const Bound& bound) {
    return check::all_free(term, [&](check::VariableId v) { return bool{bound[v.index()]}; });
}

namespace {

Known known_of(Explainer& explainer, const check::Atom& atom, const Bound& bound, Values& values) {
    const check::Predicate& p = explainer.predicate(atom.predicate);
    const auto value_of = [&](const check::Term& term, const check::Type& type) -> std::optional<Value> {
        if (term.op == check::Op::Anonymous || !all_bound(term, bound)) return std::nullopt;
        const Value v = explainer.terms().value_as(term, type, values);
        if (!explainer.terms().scratch.went_well()) return std::nullopt;
        return explainer.keep(type, v);
    };
    Known out{.predicate = atom.predicate};
    if (const auto catom = value_of(atom.arguments[0], check::Type::Node)) out.catom = catom->catom;
    for (std::size_t a = 1; a < atom.arguments.size(); ++a) out.arguments.push_back(value_of(atom.arguments[a], p.arguments[a].type));
    return out;
}

// Of a part that should be met: the facts of it that there are together, and what then fails.
Failure failure_of_part(Explainer& explainer, const PartialMatch& match, const std::vector<Clause>& part, const Values& values,
                        const Bound& bound) {
    Failure out;
    Attempt best;
    const auto further = [&](const Attempt& attempt) {
        out = {};
        if (attempt.failed == nullptr) return;
        const Clause& c = *attempt.failed;
        Values found = attempt.values;
        std::vector<std::string> met;
        for (const Clause* other : attempt.met)
            if (other != &c && other->kind == Clause::Kind::Atom)
                met.push_back(explainer.text(known_of(explainer, other->atom, attempt.bound, found)));
        if (!met.empty()) out.note = fmt::format("beside {} ", fmt::join(met, ", "));
        if (c.kind == Clause::Kind::Atom) out.missing = missing_fact(explainer, c.atom, attempt.bound, found);
        if (out.missing) {
            out.note += "this does not hold:";
            return;
        }
        out.note += "this fails: " + explainer.print(explainer.named(match, attempt.values, attempt.bound), c);
        if (c.kind != Clause::Kind::Not) return;
        Failure within = failure_of_absence(explainer, match, c.inner, attempt.values, attempt.bound);
        if (!within.note.empty()) out.note += ": " + within.note;
        out.missing = std::move(within.missing);
    };
    static_cast<void>(
        explainer.search_part(match, part, values, bound, {.best = &best, .further = further}, [](const Solution&) { return false; }));
    return out;
}

}  // namespace

std::optional<Known> missing_fact(Explainer& explainer, const check::Atom& atom, const Bound& bound, Values& values) {
    Known out = known_of(explainer, atom, bound, values);
    if (!out.catom || (explainer.facts(0).exists(*out.catom) && explainer.holds(out))) return std::nullopt;
    return out;
}

Failure failure_of_absence(Explainer& explainer, const PartialMatch& match, const std::vector<Clause>& inner, const Values& values,
                           const Bound& bound) {
    Failure out;
    static_cast<void>(explainer.search_part(match, inner, values, bound, {}, [&](const Solution& solution) {
        std::vector<std::string> holds;
        for (std::size_t n = 0; n < inner.size(); ++n)
            if (solution.facts[n] != nullptr)
                holds.push_back(explainer.text(explainer.keep(inner[n].atom.predicate, *solution.facts[n], 0)));
        Bound with = bound;
        bind_by(inner, with);
        Failure beside;
        for (const Clause& absent : inner) {
            if (beside.missing || absent.kind != Clause::Kind::Not) continue;
            if (Failure one = failure_of_part(explainer, match, absent.inner, solution.values, with); one.missing || beside.note.empty())
                beside = std::move(one);
        }
        if (!holds.empty()) out.note = fmt::format("{} {}", fmt::join(holds, ", "), beside.note.empty() ? "holds" : "holds, and ");
        out.note += beside.note;
        out.missing = std::move(beside.missing);
        return false;
    }));
    return out;
}

}  // namespace meld::inspect
