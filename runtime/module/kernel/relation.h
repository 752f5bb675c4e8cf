// A predicate at the catom under evaluation: the facts that hold, the proposals of rules, and how far its values have changed. rows.h
// describes T.
#pragma once

#include "runtime/module/abi/counts_abi.h"
#include "runtime/module/kernel/rows.h"

// Marks the steps of an evaluation. In a long module they are separate functions, which compiles in half the time; in a short one they are
// inlined, which runs some 7 % faster. The compiler decides.
#ifndef MELD_STEP
#define MELD_STEP
#endif

namespace meld {

// Defined by modules that count what their rules do (counts.h); others do nothing for it.
#ifdef MELD_COUNTS
inline constexpr bool kCounts = true;
#else
inline constexpr bool kCounts = false;
#endif

// Defined by modules whose catoms may have any number of neighbours: most of these propose the same, so proposals that decide nothing are
// worth a look. Counters see all of them.
#if defined(MELD_BY_LINKS) && !defined(MELD_COUNTS)
inline constexpr bool kManyLinks = true;
#else
inline constexpr bool kManyLinks = false;
#endif

// The number of the predicate with rows of type T: a constant of T, or, if T serves several predicates, set when a view is opened.
template <class T>
struct PredicateNumber {
    static u16 value() { return T::kPredicate; }
};
template <class T>
    requires(T::kShared)
struct PredicateNumber<T> {
    u16 number;
    u16 value() const { return number; }
};

template <class T>
void set_number(PredicateNumber<T>& predicate, u16 number) {
    if constexpr (requires { predicate.number; }) predicate.number = number;
}

// An evaluation has found derivations in quarantine.
template <class T>
void count_waiting(Eval& e, PredicateNumber<T> predicate, u32 derivations) {
    if (!kCounts || derivations == 0) return;
    e.counters->predicates[predicate.value()].waiting += derivations;
    e.counters->predicates[predicate.value()].last_tick = e.subdomain->now;
}

inline void check_fact_limit(Eval& e, u32 count, u32 rule) {
    if (count > e.subdomain->max_facts) trap(e, Trap::TooManyFacts, rule, i64{count}, static_cast<i64>(e.subdomain->max_facts));
}
// Of the facts that views derive.
template <class T>
u64 view_limit(const Eval& e) {
    return T::kGrows ? e.subdomain->max_growing_facts : e.subdomain->max_facts;
}
template <class T>
void check_view_limit(Eval& e, u32 count, u32 rule) {
    const u64 most = view_limit<T>(e);
    if (count > most) trap(e, Trap::TooManyFacts, rule, i64{count}, static_cast<i64>(most));
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

// The predicate T at the catom under evaluation: the facts that hold now, and the proposals of rules.
template <class T>
struct Relation {
    using Row = typename T::Row;
    const Row* rows;  // Sorted by key; one row a group.
    u32 count;
    const Row* origin;  // As it was before this evaluation.
    u32 origin_count;
    const RowChanges* changes;  // From origin to rows, if they were asked for.
    RowList<Row> proposed;      // Candidates of the current round.
    Row single;                 // Where rows of a Single are loaded.
    bool supported;             // Some proposal of this round supports the only row (decides_nothing()).
    u32 rule;  // The rule that a trap names: the first that derives T, then the one that made most of the latest proposals.
    bool changed;
    [[no_unique_address]] PredicateNumber<T> predicate;

    // Called by the emitted load function.
    void open(const Row* from, u32 n, u32 first_rule) {
        rows = origin = from;
        rule = first_rule;
        count = origin_count = n;
        changes = nullptr;
        start_round();
        changed = false;
    }
    void start_round() {
        proposed.reset();
        if constexpr (kManyLinks) supported = false;
    }
    MELD_PART void propose(Eval& e, const Row& row) {
        ++e.derivations;
        KERNEL_CHECK(e, proposed.count <= proposed.capacity);
        if constexpr (kManyLinks && T::kRanked && !T::kKeyed && !T::kWaits)
            if (decides_nothing(row)) return;
        // The list doubles here, so at least half of the proposals that end up in it come from now on.
        if (proposed.count == proposed.capacity && e.rule != kNone32) rule = e.rule;
        proposed.add(e, row);
    }
    // Of a group that is all of the predicate at the catom: whether an earlier proposal makes this one needless. One that supports the
    // value that holds keeps it, unless a better one comes; of equal ones that of the lowest rank does whatever the others do.
    bool decides_nothing(const Row& row) {
        if (count == 1) {
            if (supported && !T::better(row, rows[0])) return true;
            if (row.rank <= rows[0].rank && T::same(row, rows[0])) supported = true;
        }
        if (proposed.count == 0) return false;
        const Row& last = proposed.rows[proposed.count - 1];
        return last.rank <= row.rank && T::same(last, row);
    }
    // Position of the group of this row, or count.
    u32 find(const Row& group) const { return find_row<T>(rows, count, group); }
    Near near(const Row& group) const { return {lower_row<T>(rows, 0, count, group), count}; }
    void replace(const Row* with, u32 n) {
        rows = with;
        count = n;
        changes = nullptr;
        changed = true;
    }
    // Ends one of several rounds of an evaluation: its proposals are decided, and `next` holds the result if it grew.
    bool end_round(Eval& e, const RowList<Row>& next, bool grew) {
        start_round();
        if (!grew) return false;
        KERNEL_CHECK(e, next.count > 0 && one_a_group<T>(next.rows, next.count));
        check_view_limit<T>(e, next.count, rule);
        rows = next.rows;
        count = next.count;
        return true;
    }
    // Ends the evaluation after the last round: returns whether the facts differ from before.
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

// By how much a fact's value has changed since the end of the previous tick: the distance to the nearest value among the facts that are
// otherwise the same; infinite if there was none. The change holds in this tick only, so the catom is evaluated again in the next.
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
