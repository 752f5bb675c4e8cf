// Atoms that a body of a view says again: p(A) :- q(A, X), r(A), q(A, X). The second asks nothing, but it would read X a second time, and
// a view that needs only some X would seem to depend on which one it is (fronts.h).
#include <algorithm>

#include "compiler/check/check.h"

namespace meld::check {

namespace {

bool same(const Term& a, const Term& b) {
    // `_` is any value, and not the same one in two places.
    if (a.op == Op::Anonymous || a.op == Op::Let || a.op != b.op || a.type != b.type || a.variable != b.variable) return false;
    if (a.integer != b.integer || a.real != b.real || a.text != b.text || a.constant != b.constant || a.function != b.function)
        return false;
    return std::ranges::equal(a.operands, b.operands, [](const Term& x, const Term& y) { return same(x, y); });
}

bool same(const Clause& a, const Clause& b) {
    return a.kind == Clause::Kind::Atom && b.kind == Clause::Kind::Atom && a.atom.predicate == b.atom.predicate &&
           std::ranges::equal(a.atom.arguments, b.atom.arguments, [](const Term& x, const Term& y) { return same(x, y); });
}

}  // namespace

void drop_repeated_atoms(Program& program) {
    for (Rule& rule : program.rules) {
        if (rule.linear || rule.refused) continue;
        for (std::size_t i = 1; i < rule.body.size();) {
            const auto here = rule.body.begin() + static_cast<std::ptrdiff_t>(i);
            if (std::any_of(rule.body.begin(), here, [&](const Clause& c) { return same(c, *here); }))
                rule.body.erase(here);
            else
                ++i;
        }
    }
}

}  // namespace meld::check
