#include "runtime/ask/why/read_facts.h"

#include <algorithm>

namespace meld::inspect {

using check::Clause;

Bound looked_at(const Explainer& e, const PartialMatch& match, Bound bound, const Explainer::Search& search) {
    for (const Clause& c : match.body) {
        if (!e.asks_existence(match, c, search.recursion)) continue;
        for (std::size_t a = e.predicate(c.atom.predicate).aggregate_at; a < c.atom.arguments.size(); ++a)
            if (c.atom.arguments[a].is_variable()) bound[c.atom.arguments[a].variable.index()] = false;
    }
    return bound;
}

Known read_by(Explainer& e, const PartialMatch& match, const Clause& clause, const Fact& fact, std::size_t age,
              const Explainer::Search& search) {
    if (!e.asks_existence(match, clause, search.recursion)) return e.keep(clause.atom.predicate, fact, age);
    const check::Predicate& p = e.predicate(clause.atom.predicate);
    Known known{.predicate = clause.atom.predicate, .catom = fact.catom, .rank = fact.rank, .age = age};
    for (std::size_t a = 1; a < p.arguments.size(); ++a) {
        if (a < p.aggregate_at)
            known.arguments.emplace_back(e.keep(p.arguments[a].type, fact.arguments[a - 1]));
        else
            known.arguments.emplace_back();
    }
    return known;
}

std::optional<std::int64_t> oldest_tick(const Explainer& e, const PartialMatch& match, const Clause& part,
                                        const Explainer::Search& search) {
    std::size_t age = search.age;
    check::each_atom(part.inner, [&](const check::Atom& atom, bool) {
        age = std::max(age, search.age + e.age_of(match, {.kind = Clause::Kind::Atom, .atom = atom}, search.spread));
    });
    return age == 0 ? std::nullopt : std::optional(e.states().tick - static_cast<i64>(age));
}

bool says_nothing(const Explainer& e, const check::Rule& named, const Clause& clause) {
    if (clause.test.op != check::Op::Equal) return false;
    const auto side = [&](std::size_t n) { return check::print(e.checked(), named, clause.test.operands[n]); };
    return side(0) == side(1);
}

std::vector<std::string> given_to(Explainer& e, const Known& group) {
    std::vector<std::string> out;
    const check::Predicate& p = e.predicate(group.predicate);
    const std::optional<Source> base = e.base_of(group.predicate);
    if (!base) return out;
    e.facts(group.age).at(*base, *group.catom, [&](const Fact& f) {
        bool same = true;
        for (std::size_t a = 0; a + 1 < p.aggregate_at; ++a)
            same = same && e.terms().equal(p.arguments[a + 1].type, f.arguments[a], *group.arguments[a]);
        if (same) out.push_back(e.text(e.keep(group.predicate, f, group.age)));
        return true;
    });
    return out;
}

PartialMatch at_catom(const check::Rule& question, u64 catom, std::size_t last_parts) {
    PartialMatch out{.of = &question, .rule = question, .body = question.body, .own = question.body.size() - last_parts};
    out.values.resize(question.variables.count());
    out.bound.resize(question.variables.count());
    const auto first = std::ranges::find(question.body, Clause::Kind::Atom, &Clause::kind);
    if (first == question.body.end() || !first->atom.arguments[0].is_variable()) return out;
    const check::VariableId at = first->atom.arguments[0].variable;
    out.values[at.index()].catom = catom;
    out.bound[at.index()] = true;
    out.rule.site = at;
    return out;
}

}  // namespace meld::inspect
