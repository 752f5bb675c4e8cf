// The general case of recursion: several predicates, or rules that read the stratum at the same catom.
#pragma once

#include "runtime/module/kernel/ranks.h"

namespace meld {

// There is one Mutual per predicate; the emitted driver alternates rounds of all rules with these steps:
//   start; repeat { rules; keep } until nothing more is kept; lose; repeat { rules; take } until nothing more is taken;
//   if a value was replaced, start again; then finish.
template <class T>
struct Mutual {
    using Row = typename T::Row;
    Relation<T>& r;
    const Row* before;  // As it was before this stratum was evaluated.
    u32 before_count;
    const Row* old = nullptr;
    u32 old_count = 0;
    u8* kept = nullptr;
    RowList<Row> lost{};  // Groups lost in this evaluation.
    bool replaced = false;
    i64 wake = 0;
    u32 waiting = 0;  // Derivations in quarantine, in the last round.

    explicit Mutual(Relation<T>& relation) : r(relation), before(relation.rows), before_count(relation.count) { lost.reset(); }

    void start(Eval& e) {
        old = r.rows;
        old_count = r.count;
        kept = static_cast<u8*>(scratch(e, old_count + 1));
        for (u32 i = 0; i < old_count; ++i) kept[i] = 0;
        r.rows = nullptr;
        r.count = 0;
        r.start_round();
        replaced = false;
    }
    // Facts stay if a derivation from lower ranks supports them with facts that are already kept.
    MELD_STEP bool keep(Eval& e) {
        bool grew = false;
        for (u32 i = 0; i < r.proposed.count; ++i) {
            const Row& p = r.proposed.rows[i];
            const u32 at = find_row<T>(old, old_count, p);
            if (at == old_count || kept[at] || !T::same(old[at], p) || p.rank > old[at].rank) continue;
            kept[at] = 1;
            grew = true;
        }
        if (!grew) return false;  // The proposals of the last round stay for `lose`.
        r.start_round();
        Row* now = static_cast<Row*>(scratch(e, u64{old_count} * sizeof(Row)));
        u32 n = 0;
        for (u32 i = 0; i < old_count; ++i)
            if (kept[i]) now[n++] = old[i];
        r.rows = now;
        r.count = n;
        return true;
    }
    // The first tick at which the proposal may give its group a value. The tombstone of a group stands for all values it has lost, if
    // fronts (fronts.h) hold several: the values that follow from a loss come back with others.
    i64 trusted(Eval& e, const Row& p) {
        Tombstone memory{};
        const Tombstone* known = lost_before<T>(e, r.predicate, p, memory);
        for (u32 i = 0; i < lost.count; ++i)
            if (same_group(lost.rows[i], p)) {
                memory = after_loss(known, lost.rows[i].rank, e.subdomain->now);
                known = &memory;
            }
        return trusted_from(known, p.rank, e.subdomain->latency);
    }
    static bool same_group(const Row& a, const Row& b) {
        if constexpr (requires { T::group(a, b); })
            return T::group(a, b) == 0;
        else
            return T::key(a, b) == 0;
    }
    MELD_STEP void lose(Eval& e) {
        if constexpr (T::kLinks)
            for (u32 i = 0; i < old_count; ++i) {
                if (kept[i] || !was_there(old[i])) continue;
                bool superseded = false;
                for (u32 k = 0; k < r.proposed.count; ++k) {
                    const Row& p = r.proposed.rows[k];
                    superseded = superseded || (T::key(p, old[i]) == 0 && T::better(p, old[i]) && trusted(e, p) <= e.subdomain->now);
                }
                if (superseded) continue;
                lost.add(e, old[i]);
                e.host->lose(&e, r.predicate.value(), T::hash(old[i]), old[i].rank);
            }
        r.start_round();
    }
    // Nobody has seen a fact that this evaluation has derived, so there is no loss to remember.
    bool was_there(const Row& row) const {
        const u32 at = find_row<T>(r.origin, r.origin_count, row);
        return at < r.origin_count && T::same(r.origin[at], row);
    }
    // Goes through the groups with proposals, in order, and makes the next rows; the rows of all other groups stay. For each of them
    // decide(next, held, first, end) gets the proposals from `first` to `end`, takes the rows that the group has, in `r.rows` from number
    // `held` on, adds those that it will have to `next`, and returns whether one has come.
    template <class Order, class Compare, class Decide>
    [[gnu::always_inline]] bool take_groups(Eval& e, const Order& order, const Compare& compare, const Decide& decide) {
        Row* p = r.proposed.rows;
        const u32 n = r.proposed.count;
        sort_rows(e, p, n, order);
        wake = 0;
        waiting = 0;
        bool grew = false;
        RowList<Row> next;
        next.reset();
        u32 held = 0;
        for (u32 i = 0; i < n;) {
            u32 end = i + 1;
            while (end < n && compare(p[end], p[i]) == 0) ++end;
            while (held < r.count && compare(r.rows[held], p[i]) < 0) next.add(e, r.rows[held++]);
            grew = decide(next, held, p + i, p + end) || grew;
            i = end;
        }
        while (held < r.count) next.add(e, r.rows[held++]);
        return r.end_round(e, next, grew);
    }
    // Whether the proposal may give its group a value now; if not, it waits.
    bool may_enter(Eval& e, const Row& p) {
        const i64 ready = trusted(e, p);
        if (ready <= e.subdomain->now) return true;
        ++waiting;
        if (wake == 0 || ready < wake) wake = ready;
        return false;
    }
    // Groups take the best trusted value proposed.
    MELD_STEP bool take(Eval& e) {
        const auto key = [](const Row& a, const Row& b) { return T::key(a, b); };
        return take_groups(e, ChoiceOrder<T>{}, key, [&](RowList<Row>& next, u32& held, const Row* first, const Row* end) {
            const Row* current = held < r.count && T::key(r.rows[held], *first) == 0 ? &r.rows[held++] : nullptr;
            const Row* best = current;
            for (const Row* p = first; p != end; ++p)
                if ((best == nullptr || T::better(*p, *best)) && may_enter(e, *p)) best = p;
            if (best != nullptr) next.add(e, *best);
            if (best == current) return false;
            replaced = replaced || current != nullptr;
            note_rank(e, best->rank);
            return true;
        });
    }
    bool finish(Eval& e) {
        count_waiting<T>(e, r.predicate, waiting);
        wake_at(e, wake);
        return r.end_rounds(before, before_count);
    }
};

}  // namespace meld
