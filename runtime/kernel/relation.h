// A predicate at the catom under evaluation: what holds of it, what rules propose, and how far its values have changed.
// What T is, is said in rows.h.
#pragma once

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

}  // namespace meld
