// Atoms that a body of a view says again: p(A) :- q(A, X), r(A), q(A, X). The second asks nothing, but it would read X a second time, and
// a view that needs only some X would seem to depend on which one it is (fronts.h). Cost: linear in the bodies, which may be long.
#include <algorithm>
#include <unordered_map>
#include <utility>

#include "compiler/check/check.h"
#include "runtime/base/hash.h"

namespace meld::check {

namespace {

// `_` is any value, and not the same one in two places.
bool can_be_said_again(const Clause& clause) {
    if (clause.kind != Clause::Kind::Atom) return false;
    bool known = true;
    for (const Term& argument : clause.atom.arguments)
        each_subterm(argument, [&](const Term& t) { known = known && t.op != Op::Anonymous && t.op != Op::Let; });
    return known;
}

bool same(const Term& a, const Term& b) {
    if (a.op != b.op || a.type != b.type || a.variable != b.variable) return false;
    if (a.integer != b.integer || a.real != b.real || a.text != b.text || a.constant != b.constant || a.function != b.function)
        return false;
    return std::ranges::equal(a.operands, b.operands, [](const Term& x, const Term& y) { return same(x, y); });
}

bool same(const Atom& a, const Atom& b) {
    return a.predicate == b.predicate &&
           std::ranges::equal(a.arguments, b.arguments, [](const Term& x, const Term& y) { return same(x, y); });
}

// Equal for the same atoms, and seldom for others.
std::uint64_t hash_of(const Atom& atom) {
    std::uint64_t hash = atom.predicate.index();
    for (const Term& argument : atom.arguments)
        each_subterm(argument, [&](const Term& t) {
            hash = hash_combine(hash, static_cast<std::uint64_t>(t.op));
            hash = hash_combine(hash, t.variable.index());
            hash = hash_combine(hash, static_cast<std::uint64_t>(t.integer));
            hash = hash_text(t.text, hash_combine(hash, std::hash<double>{}(t.real)));
        });
    return hash;
}

}  // namespace

void drop_repeated_atoms(Program& program) {
    for (Rule& rule : program.rules) {
        if (rule.linear || rule.refused) continue;
        std::vector<Clause> kept;
        kept.reserve(rule.body.size());
        std::unordered_multimap<std::uint64_t, std::size_t> said;  // Places in `kept`, by hash.
        for (Clause& clause : rule.body) {
            if (can_be_said_again(clause)) {
                const std::uint64_t hash = hash_of(clause.atom);
                const auto [first, last] = said.equal_range(hash);
                if (std::any_of(first, last, [&](const auto& one) { return same(kept[one.second].atom, clause.atom); })) continue;
                said.emplace(hash, kept.size());
            }
            kept.push_back(std::move(clause));
        }
        rule.body = std::move(kept);
    }
}

}  // namespace meld::check
