// The evaluation steps that every emitted module shares, as templates over its row types. Emitted code includes this one
// header; a rule becomes a plain loop that adds candidates, and these templates decide what holds.
//
// What T is, is said in rows.h.
#pragma once

#include "runtime/kernel/aggregates.h"
#include "runtime/kernel/rows.h"

// Marks the steps of an evaluation. In a long module they stay functions of their own, which compiles in half the time; in a
// short one they are inlined where they are called, which runs some 7 % faster. The compiler says which.
#ifndef MELD_STEP
#define MELD_STEP
#endif

namespace meld {

inline void check_fact_limit(Eval& e, u32 count, u32 rule) {
    if (count > e.subdomain->max_facts) trap(e, Trap::TooManyFacts, rule, i64{count}, static_cast<i64>(e.subdomain->max_facts));
}

template <class T>
bool equal_rows(const typename T::Row* a, u32 n, const typename T::Row* b, u32 m) {
    if (n != m) return false;
    for (u32 i = 0; i < n; ++i) {
        if (T::key(a[i], b[i]) != 0 || !T::same(a[i], b[i])) return false;
        if constexpr (T::kRanked)
            if (a[i].rank != b[i].rank) return false;
    }
    return true;
}

// The predicate T at the catom under evaluation: what holds now, and what rules have proposed.
template <class T>
struct Relation {
    using Row = typename T::Row;
    const Row* rows;  // Sorted by key; one row a group.
    u32 count;
    const Row* origin;  // As it was before this evaluation.
    u32 origin_count;
    const RowChanges* changes;  // From origin to rows, where somebody has asked for it.
    RowList<Row> proposed;      // Candidates of the current round.
    Row single;                 // Where rows of a Single are loaded to.
    u32 rule;                   // That a trap names: the first that derives T.
    bool changed;

    // Called by the emitted load function.
    void open(const Row* from, u32 n, u32 first_rule) {
        rows = origin = from;
        rule = first_rule;
        count = origin_count = n;
        changes = nullptr;
        proposed.reset();
        changed = false;
    }
    void propose(Eval& e, const Row& row) {
        ++e.derivations;
        proposed.add(e, row);
    }
    // Position of the group of this row, or count.
    u32 find(const Row& group) const { return find_row<T>(rows, count, group); }
    void replace(const Row* with, u32 n) {
        rows = with;
        count = n;
        changes = nullptr;
        changed = true;
    }
    // Ends a round of an evaluation in several: its proposals are decided and `next` is what holds then, where it grew at all.
    bool end_round(Eval& e, const RowList<Row>& next, bool grew) {
        proposed.reset();
        if (!grew) return false;
        check_fact_limit(e, next.count, rule);
        rows = next.rows;
        count = next.count;
        return true;
    }
    // Ends the evaluation after the last round: whether something else holds than before.
    bool end_rounds(const Row* before, u32 before_count) {
        if (equal_rows<T>(rows, count, before, before_count)) {
            rows = before;
            return false;
        }
        changed = true;
        return true;
    }
};

// ---- class 1: not recursive. The proposals are all there is: reduce each group and compare with what was.
// Cost: one sort of the proposals. combine, needed: as of reduce_group(). Returns whether anything changed.
template <class T, class Combine = OwnCombine<T>>
MELD_STEP bool evaluate_plain(Eval& e, Relation<T>& r, const Combine& combine = {}, u32 needed = 0) {
    using Row = typename T::Row;
    Row* p = r.proposed.rows;
    const u32 n = r.proposed.count;
    sort_candidates<T>(e, p, n);
    u32 kept = 0;
    for (u32 i = 0; i < n;) {
        u32 end = i + 1;
        while (end < n && T::key(p[end], p[i]) == 0) ++end;
        const Row* held = nullptr;
        if constexpr (T::kReduce == Reduce::First || T::kReduce == Reduce::Since)
            if (const u32 at = r.find(p[i]); at < r.count) held = &r.rows[at];
        Row out;
        if (reduce_group<T>(e, held, p + i, end - i, combine, needed, out)) p[kept++] = out;
        i = end;
    }
    check_fact_limit(e, kept, r.rule);
    r.proposed.reset();
    if (equal_rows<T>(r.rows, r.count, p, kept)) return false;
    r.replace(p, kept);
    return true;
}

// ---- recursion: ranks and quarantine (docs/design.md, "Ranks and quarantine")

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
const Tombstone* lost_before(Eval& e, const typename T::Row& group, Tombstone& out) {
    if constexpr (!T::kLinks)
        return nullptr;
    else if (!e.subdomain->tombstones)
        return nullptr;
    else
        return e.host->tombstone(&e, T::kPredicate, T::hash(group), &out) ? &out : nullptr;
}

inline void wake_at(Eval& e, i64 tick) {
    if (tick != 0) e.host->wake(&e, tick, kDirtyWake);
}

// Whether the time has come; if not, the catom is looked at again when it has.
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
    if (rank > e.greatest_rank) e.greatest_rank = rank;
}

// Decides one group that no rule of the same catom reads back: `current` may be null; proposals are in any order.
// Returns whether `out` holds a value.
template <class T>
bool decide_group(Eval& e, const typename T::Row* current, const typename T::Row* proposals, u32 n, typename T::Row& out) {
    using Row = typename T::Row;
    const i64 now = e.subdomain->now;
    const u32 latency = e.subdomain->latency;
    Tombstone memory{};
    const Tombstone* lost = nullptr;
    bool asked = false;
    const auto remembered = [&](const Row& group) {
        if (!asked) lost = lost_before<T>(e, group, memory);
        asked = true;
        return lost;
    };
    const Row* best = nullptr;
    if (current != nullptr) {
        bool supported = false, superseded = false;
        for (u32 i = 0; i < n; ++i) {
            if (T::same(proposals[i], *current))
                supported |= proposals[i].rank <= current->rank;
            else if (T::better(proposals[i], *current))
                superseded = superseded || trusted_from(remembered(proposals[i]), proposals[i].rank, latency) <= now;
        }
        if (supported)
            best = current;
        else if (!superseded) {
            if constexpr (T::kLinks) {
                remembered(*current);
                memory = after_loss(lost, current->rank, now);
                lost = &memory;
                e.host->lose(&e, T::kPredicate, T::hash(*current), current->rank);
            }
        }
    }
    bool quarantined = false;
    for (u32 i = 0; i < n; ++i) {
        const Row& p = proposals[i];
        if (best != nullptr) {
            if (best == current ? !T::better(p, *best) : !ChoiceOrder<T>{}(p, *best)) continue;
        }
        if (trusted_from(remembered(p), p.rank, latency) > now)
            quarantined = true;
        else
            best = &p;
    }
    if (quarantined) {
        i64 wake = 0;
        for (u32 i = 0; i < n; ++i) {
            if (best != nullptr && !T::better(proposals[i], *best)) continue;
            const i64 ready = trusted_from(remembered(proposals[i]), proposals[i].rank, latency);
            if (ready > now && (wake == 0 || ready < wake)) wake = ready;
        }
        if constexpr (T::kFollowed)
            e.host->wake_group(&e, wake, T::kPredicate, proposals);
        else
            wake_at(e, wake);
    }
    if (best == nullptr) return false;
    out = *best;
    note_rank(e, out.rank);
    return true;
}

// A recursive predicate whose rules read it only at neighbours: each group is decided once.
template <class T>
MELD_STEP bool evaluate_ranked(Eval& e, Relation<T>& r) {
    using Row = typename T::Row;
    Row* p = r.proposed.rows;
    const u32 n = r.proposed.count;
    if constexpr (!T::kKeyed) {
        Row* out = static_cast<Row*>(scratch(e, sizeof(Row)));
        const bool holds = decide_group<T>(e, r.count ? r.rows : nullptr, p, n, *out);
        r.proposed.reset();
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
            // The next group in order is a held one, a proposed one, or both.
            const int side = i == n ? 1 : held == r.count ? -1 : T::key(p[i], r.rows[held]);
            const Row* current = side >= 0 ? &r.rows[held] : nullptr;
            const u32 from = i;
            if (side <= 0)
                while (i < n && T::key(p[i], p[from]) == 0) ++i;
            Row out;
            const bool holds = decide_group<T>(e, current, p + from, i - from, out);
            if (holds) next.add(e, out);
            changed = changed || holds != (current != nullptr) || (holds && (!T::same(out, *current) || out.rank != current->rank));
            if (current != nullptr) ++held;
        }
        check_fact_limit(e, next.count, r.rule);
        r.proposed.reset();
        if (changed) r.replace(next.rows, next.count);
        return changed;
    }
}

// The general case: several predicates, or rules that read the stratum at the same catom. One Mutual per predicate;
// the emitted driver alternates rounds of all rules with these steps:
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

    explicit Mutual(Relation<T>& relation) : r(relation), before(relation.rows), before_count(relation.count) { lost.reset(); }

    void start(Eval& e) {
        old = r.rows;
        old_count = r.count;
        kept = static_cast<u8*>(scratch(e, old_count + 1));
        for (u32 i = 0; i < old_count; ++i) kept[i] = 0;
        r.rows = nullptr;
        r.count = 0;
        r.proposed.reset();
        replaced = false;
    }
    // Facts with a derivation from lower ranks, out of facts already kept, stay.
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
        r.proposed.reset();
        Row* now = static_cast<Row*>(scratch(e, u64{old_count} * sizeof(Row)));
        u32 n = 0;
        for (u32 i = 0; i < old_count; ++i)
            if (kept[i]) now[n++] = old[i];
        r.rows = now;
        r.count = n;
        return true;
    }
    // The first tick at which the proposal may give its group a value. The tombstone of a group is that of all values it has
    // lost, where fronts (fronts.h) hold several: those that a loss leads to come back with others.
    i64 trusted(Eval& e, const Row& p) {
        Tombstone memory{};
        const Tombstone* known = lost_before<T>(e, p, memory);
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
                e.host->lose(&e, T::kPredicate, T::hash(old[i]), old[i].rank);
            }
        r.proposed.reset();
    }
    // A fact that this evaluation has derived was seen by nobody, so there is no loss to remember.
    bool was_there(const Row& row) const {
        const u32 at = find_row<T>(r.origin, r.origin_count, row);
        return at < r.origin_count && T::same(r.origin[at], row);
    }
    // Groups take the best trusted value proposed.
    MELD_STEP bool take(Eval& e) {
        Row* p = r.proposed.rows;
        const u32 n = r.proposed.count;
        sort_rows(e, p, n, ChoiceOrder<T>{});
        wake = 0;
        bool grew = false;
        RowList<Row> next;
        next.reset();
        u32 held = 0;
        for (u32 i = 0; i < n;) {
            u32 end = i + 1;
            while (end < n && T::key(p[end], p[i]) == 0) ++end;
            while (held < r.count && T::key(r.rows[held], p[i]) < 0) next.add(e, r.rows[held++]);
            const Row* current = held < r.count && T::key(r.rows[held], p[i]) == 0 ? &r.rows[held++] : nullptr;
            const Row* best = current;
            for (u32 k = i; k < end; ++k) {
                if (best != nullptr && !T::better(p[k], *best)) continue;
                const i64 ready = trusted(e, p[k]);
                if (ready <= e.subdomain->now)
                    best = &p[k];
                else if (wake == 0 || ready < wake)
                    wake = ready;
            }
            if (best != current) {
                grew = true;
                replaced = replaced || current != nullptr;
                note_rank(e, best->rank);
            }
            if (best != nullptr) next.add(e, *best);
            i = end;
        }
        while (held < r.count) next.add(e, r.rows[held++]);
        return r.end_round(e, next, grew);
    }
    bool finish(Eval& e) {
        wake_at(e, wake);
        return r.end_rounds(before, before_count);
    }
};

// Recursive through local rules only, sets without aggregates: from scratch inside the tick, nothing remembered.
template <class T>
MELD_STEP bool gather(Eval& e, Relation<T>& r) {
    using Row = typename T::Row;
    Row* p = r.proposed.rows;
    const u32 n = r.proposed.count;
    sort_rows(e, p, n, ChoiceOrder<T>{});
    RowList<Row> next;
    next.reset();
    u32 held = 0;
    bool grew = false;
    for (u32 i = 0; i < n; ++i) {
        if (i > 0 && T::key(p[i - 1], p[i]) == 0) continue;
        while (held < r.count && T::key(r.rows[held], p[i]) < 0) next.add(e, r.rows[held++]);
        if (held < r.count && T::key(r.rows[held], p[i]) == 0) continue;
        next.add(e, p[i]);
        grew = true;
    }
    while (held < r.count) next.add(e, r.rows[held++]);
    return r.end_round(e, next, grew);
}

// ---- change

inline double distance(i64 a, i64 b) {
    return static_cast<double>(a < b ? static_cast<u64>(b) - static_cast<u64>(a) : static_cast<u64>(a) - static_cast<u64>(b));
}
inline double distance(double a, double b) { return __builtin_fabs(a - b); }

// By how much a fact's value has changed since the end of the tick before: from the nearest value among the facts that are
// the same otherwise; infinite where there was none. A change is one in this tick alone, so the catom looks again in the next.
template <class T, class Same, class Value>
double change_of(Eval& e, const Relation<T>& r, const typename T::Row& now, const Same& same, const Value& value) {
    double least = __builtin_inf();
    for (u32 i = 0; i < r.origin_count; ++i) {
        if (!same(now, r.origin[i])) continue;
        const double d = distance(value(now), value(r.origin[i]));
        if (d < least) least = d;
    }
    if (least != 0) e.host->wake(&e, e.subdomain->now + 1, kDirtyWake);
    return least;
}

// ---- linear facts: a sorted bag; the lowest fact that fits is matched first.

template <class T>
struct Bag {
    using Row = typename T::Row;
    RowList<Row> list;
    RowList<Row> held;  // Made while a comprehension consumes this bag: they join it when it ends.
    u32 rule;           // That a trap names: the first that derives T.
    bool holding;
    bool changed;

    void open(Eval& e, const Row* from, u32 n, u32 first_rule) {
        rule = first_rule;
        list.reset();
        held.reset();
        for (u32 i = 0; i < n; ++i) list.add(e, from[i]);
        changed = holding = false;
    }
    void hold() { holding = true; }
    void release(Eval& e) {
        holding = false;
        for (u32 i = 0; i < held.count; ++i) insert(e, held.rows[i]);
        held.clear();
    }
    void add(Eval& e, const Row& row) {
        ++e.derivations;
        if (holding)
            held.add(e, row);
        else
            insert(e, row);
    }
    MELD_STEP void insert(Eval& e, const Row& row) {
        list.add(e, row);
        u32 at = list.count - 1;
        while (at > 0 && T::key(row, list.rows[at - 1]) < 0) {
            list.rows[at] = list.rows[at - 1];
            --at;
        }
        list.rows[at] = row;
        changed = true;
        check_fact_limit(e, list.count, rule);
    }
    // Removes the facts at these positions, in any order; `positions` is sorted on the way.
    void remove_all(u32* positions, u32 n) {
        for (u32 i = 1; i < n; ++i)
            for (u32 k = i; k > 0 && positions[k] > positions[k - 1]; --k) {
                const u32 swap = positions[k];
                positions[k] = positions[k - 1];
                positions[k - 1] = swap;
            }
        for (u32 i = 0; i < n; ++i) remove(positions[i]);
    }
    // The shorter side moves: mostly facts are consumed from the front, and there may be a hundred thousand.
    void remove(u32 at) {
        if (at < list.count / 2) {
            for (u32 i = at; i > 0; --i) list.rows[i] = list.rows[i - 1];
            ++list.rows;
            --list.capacity;
        } else {
            for (u32 i = at + 1; i < list.count; ++i) list.rows[i - 1] = list.rows[i];
        }
        --list.count;
        changed = true;
    }
};

// Persistent facts given by linear rules, messages or the world: a sorted set that only grows.
template <class T>
bool give_base(Eval& e, Relation<T>& r, const typename T::Row& row) {
    if (r.find(row) < r.count) return false;
    ++e.derivations;
    RowList<typename T::Row> next;
    next.reset();
    u32 held = 0;
    while (held < r.count && T::key(r.rows[held], row) < 0) next.add(e, r.rows[held++]);
    next.add(e, row);
    while (held < r.count) next.add(e, r.rows[held++]);
    check_fact_limit(e, next.count, r.rule);
    r.replace(next.rows, next.count);
    return true;
}

}  // namespace meld
