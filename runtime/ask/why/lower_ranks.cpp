#include "runtime/ask/why/lower_ranks.h"

namespace meld::inspect {

using check::Clause;

LowerRanks::Allowed LowerRanks::than(const PartialMatch& match, const Known& head) {
    const check::Stratum* const recursion = e_.recursion_of(head.predicate);
    if (recursion == nullptr) return {};
    if (head.rank != kAbsent)
        return [this, recursion, &match, &head, own = Existence::What{head.predicate, match.open}](const Clause& c, const Fact& f) {
            if (!recursion->contains(c.atom.predicate) || f.rank == kAbsent) return true;
            const Existence& existence = e_.existence();
            if (existence.any() && !existence.comparable(own, {c.atom.predicate, e_.asks_existence(match, c, recursion)})) return true;
            return f.rank < head.rank;
        };
    if (recursion->links) return {};
    // At one catom nothing is stored: ranks are the rounds of a computation from nothing.
    const auto& rounds = rounds_.of(*recursion, *head.catom, head.age);
    const auto own = rounds.find(e_.text(head));
    const std::size_t round = own == rounds.end() ? 0 : own->second;
    return [this, recursion, &rounds, round, age = head.age](const Clause& c, const Fact& f) {
        if (!recursion->contains(c.atom.predicate)) return true;
        const auto known = rounds.find(e_.text(e_.keep(c.atom.predicate, f, age)));
        return known != rounds.end() && known->second < round;
    };
}

}  // namespace meld::inspect
