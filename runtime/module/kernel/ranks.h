// Recursion over links: ranks and quarantine (docs/design.md, "Ranks and quarantine"). A group keeps a value while a fact of lower rank
// supports it, and trusts a lost value again only after all facts that depended on it must have disappeared.
#pragma once

#include "runtime/module/kernel/relation.h"

namespace meld {

// The hash of a group is that of its values mixed into this one: by it a run keeps what groups have lost.
constexpr u64 kGroupHash = 0x9e37;

// The first tick at which a proposal may give its group a value; 0: at once.
inline i64 trusted_from(const Tombstone* lost, u32 rank, u32 latency) {
    if (lost == nullptr || rank <= lost->least_rank) return 0;
    return lost->time + (i64{rank} - i64{lost->least_rank} + 1) * latency + 1;
}
// The tombstone of a group that loses a value of this rank now. `known` is the one it has, or null.
inline Tombstone after_loss(const Tombstone* known, u32 rank, i64 now) {
    return {known != nullptr && known->least_rank < rank ? known->least_rank : rank, now};
}

template <class T>
const Tombstone* lost_before(Eval& e, PredicateNumber<T> predicate, const typename T::Row& group, Tombstone& out) {
    if constexpr (!T::kLinks)
        return nullptr;
    else if (!e.subdomain->tombstones)
        return nullptr;
    else
        return e.host->tombstone(&e, predicate.value(), T::hash(group), &out) ? &out : nullptr;
}

inline void wake_at(Eval& e, i64 tick) {
    if (tick != 0) e.host->wake(&e, tick, kDirtyWake);
}

// Whether the time has come; if not, sets a timer to look at the catom again.
inline bool due(Eval& e, i64 tick) {
    if (tick > e.subdomain->now) e.host->wake(&e, tick, kDirtyWake);
    return tick <= e.subdomain->now;
}

// One more than the largest rank among body facts.
inline u32 rank_above(u32 a) { return a + 1; }
inline u32 rank_above(u32 a, u32 b) { return (a > b ? a : b) + 1; }
template <class... More>
u32 rank_above(u32 a, u32 b, More... more) {
    return rank_above(a > b ? a : b, more...);
}

inline void note_rank(Eval& e, u32 rank) {
    if (rank <= e.greatest_rank) return;
    e.greatest_rank = rank;
    if (rank > kMaxRank) trap(e, Trap::RankTooHigh, e.rule, i64{rank}, i64{kMaxRank});
}

// One group that no rule of the same catom reads back, and the proposals for it in any order; `current` is null if it has no value.
template <class T>
struct GroupDecision {
    using Row = typename T::Row;
    Eval& e;
    [[no_unique_address]] PredicateNumber<T> predicate;
    const Row* current;
    const Row* proposals;
    u32 n;
    // What the group has lost, once somebody has asked for it.
    const Tombstone* lost = nullptr;
    bool asked = false;
    Tombstone memory{};

    // Nothing has been lost, so all proposals are trusted. Null: the group has no value, or loses it now.
    [[gnu::always_inline]] const Row* without_losses() const {
        bool supported = false;
        const Row* first = nullptr;
        for (u32 i = 0; i < n; ++i) {
            const Row& p = proposals[i];
            if (current != nullptr) supported |= p.rank <= current->rank && T::same(p, *current);
            if (first == nullptr || ChoiceOrder<T>{}(p, *first)) first = &p;
        }
        const Row* const holds = current == nullptr || (first != nullptr && T::better(*first, *current)) ? first
                                 : supported                                                             ? current
                                                                                                         : nullptr;
        // If the value is lost, nothing else is offered.
        KERNEL_CHECK(e, holds != nullptr || current == nullptr || first == nullptr || !T::better(*first, *current));
        return holds;
    }

    const Row* with_losses() {
        bool quarantined = false;
        const Row* const best = best_trusted(still_supported(), quarantined);
        if (quarantined) wake_for_better(best);
        return best;
    }

  private:
    const Tombstone* remembered(const Row& group) {
        if (!asked) lost = lost_before<T>(e, predicate, group, memory);
        asked = true;
        return lost;
    }
    // The first tick at which the group may take a proposal.
    i64 ready(const Row& p) { return trusted_from(remembered(p), p.rank, e.subdomain->latency); }

    // The current value if a proposal supports it. If none does and no better one takes its place, the group loses it.
    const Row* still_supported() {
        if (current == nullptr) return nullptr;
        const i64 now = e.subdomain->now;
        bool supported = false, superseded = false;
        for (u32 i = 0; i < n; ++i) {
            if (T::same(proposals[i], *current))
                supported |= proposals[i].rank <= current->rank;
            else if (T::better(proposals[i], *current))
                superseded = superseded || ready(proposals[i]) <= now;
        }
        if (supported) return current;
        if (superseded) return nullptr;
        if constexpr (T::kLinks) {
            remembered(*current);
            memory = after_loss(lost, current->rank, now);
            lost = &memory;
            e.host->lose(&e, predicate.value(), T::hash(*current), current->rank);
        }
        return nullptr;
    }
    const Row* best_trusted(const Row* best, bool& quarantined) {
        const i64 now = e.subdomain->now;
        for (u32 i = 0; i < n; ++i) {
            const Row& p = proposals[i];
            if (best != nullptr) {
                if (best == current ? !T::better(p, *best) : !ChoiceOrder<T>{}(p, *best)) continue;
            }
            if (ready(p) > now) {
                quarantined = true;
                count_waiting<T>(e, predicate, 1);
            } else {
                KERNEL_CHECK(e, best == nullptr || !T::better(*best, p));
                best = &p;
            }
        }
        return best;
    }
    // For the first of the proposals in quarantine that would be better.
    void wake_for_better(const Row* best) {
        const i64 now = e.subdomain->now;
        i64 wake = 0;
        for (u32 i = 0; i < n; ++i) {
            if (best != nullptr && !T::better(proposals[i], *best)) continue;
            const i64 at = ready(proposals[i]);
            if (at > now && (wake == 0 || at < wake)) wake = at;
        }
        if constexpr (T::kFollowed)
            e.host->wake_group(&e, wake, predicate.value(), proposals);
        else
            wake_at(e, wake);
    }
};

// Returns whether `out` holds a value.
template <class T>
bool decide_group(Eval& e, PredicateNumber<T> predicate, const typename T::Row* current, const typename T::Row* proposals, u32 n,
                  typename T::Row& out) {
    KERNEL_CHECK(e, of_one_group<T>(proposals, n));
    KERNEL_CHECK(e, current == nullptr || n == 0 || T::key(*current, proposals[0]) == 0);
    GroupDecision<T> group{e, predicate, current, proposals, n};
    const typename T::Row* value = nullptr;
    if (!e.subdomain->tombstones) {
        value = group.without_losses();
        if (value == nullptr && current == nullptr) return false;
    }
    if (value == nullptr) value = group.with_losses();
    if (value == nullptr) return false;
    KERNEL_CHECK(e, value->rank != kAbsent);
    out = *value;
    note_rank(e, out.rank);
    return true;
}

// What a rule derives from the fact of one neighbour alone, before the neighbour changes and after.
template <class T>
struct Offer {
    typename T::Row before, after;
    bool had, has;
};

// Had: whether there were offers before, or one has no value. Of a wave that arrives for the first time less is asked.
template <bool Had, class T, u32 N, class Fact>
u32 concerned_where(Eval& e, const Offer<T> (&offers)[N], const i32* neighbours, u32 count, u32* out, const Fact& fact) {
    // An offer without a value, which is known where it is derived.
    const bool undefined = Had && e.trap != Trap::None;
    if (Had) e.trap = Trap::None;
    u32 n = 0;
    for (u32 i = 0; i < count; ++i) {
        if (neighbours[i] < 0) continue;
        typename T::Row held{};
        const bool holds = fact(static_cast<u32>(neighbours[i]), held);
        bool concerned = undefined;
        for (u32 k = 0; k < N; ++k) {
            const Offer<T>& o = offers[k];
            concerned |= o.has & (!holds | T::better(o.after, held));
            if (Had) concerned |= o.had & holds & (o.before.rank <= held.rank) & T::same(o.before, held);
        }
        out[n] = static_cast<u32>(neighbours[i]);
        n += concerned;
    }
    return n;
}

// Of these neighbours (-1: none) of a catom that changes, writes to `out` those that are to decide the only group of T again. One that
// holds a value does not, if no offer supports it that has gone, and none has come that is better: decide_group() would keep the value.
// fact(catom, row): whether it holds a value, which becomes `row`.
template <class T, u32 N, class Fact>
u32 concerned_by(Eval& e, const Offer<T> (&offers)[N], const i32* neighbours, u32 count, u32* out, const Fact& fact) {
    bool had = e.trap != Trap::None;
    for (u32 k = 0; k < N; ++k) had |= offers[k].had;
    return had ? concerned_where<true>(e, offers, neighbours, count, out, fact)
               : concerned_where<false>(e, offers, neighbours, count, out, fact);
}

// A recursive predicate whose rules read it only at neighbours: each group is decided once.
template <class T>
MELD_STEP bool evaluate_ranked(Eval& e, Relation<T>& r) {
    using Row = typename T::Row;
    Row* p = r.proposed.rows;
    const u32 n = r.proposed.count;
    if constexpr (!T::kKeyed) {
        Row* out = static_cast<Row*>(scratch(e, sizeof(Row)));
        const bool holds = decide_group<T>(e, r.predicate, r.count ? r.rows : nullptr, p, n, *out);
        r.start_round();
        if (holds == (r.count == 1) && (!holds || (T::same(*out, r.rows[0]) && out->rank == r.rows[0].rank))) return false;
        r.replace(out, holds ? 1 : 0);
        return true;
    } else {
        sort_rows(e, p, n, [](const Row& a, const Row& b) { return T::key(a, b) < 0; });
        RowList<Row> next;
        next.reset();
        bool changed = false;
        u32 i = 0, held = 0;
        while (i < n || held < r.count) {
            // The next group in order has a held row, a proposed one, or both.
            const int side = i == n ? 1 : held == r.count ? -1 : T::key(p[i], r.rows[held]);
            const Row* current = side >= 0 ? &r.rows[held] : nullptr;
            const u32 from = i;
            if (side <= 0)
                while (i < n && T::key(p[i], p[from]) == 0) ++i;
            Row out;
            const bool holds = decide_group<T>(e, r.predicate, current, p + from, i - from, out);
            if (holds) next.add(e, out);
            changed = changed || holds != (current != nullptr) || (holds && (!T::same(out, *current) || out.rank != current->rank));
            if (current != nullptr) ++held;
        }
        check_view_limit<T>(e, next.count, r.rule);
        r.start_round();
        if (changed) r.replace(next.rows, next.count);
        return changed;
    }
}

}  // namespace meld
