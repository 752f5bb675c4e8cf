// Evaluates a predicate with many rows if only some rows of its inputs have changed: finds the groups that these rows can affect, derives
// them again and decides them; all others stay as they are. Included by modules with such rules.
//
// The result is the same as evaluating the whole predicate: a group whose inputs are unchanged would be decided as before.
#pragma once

#include "runtime/module/kernel/views.h"

namespace meld {

template <class Row>
const Row* rows_in(const RowChanges* c) {
    return reinterpret_cast<const Row*>(c + 1);
}

template <class Row>
RowChanges* new_changes(Eval& e, const Row* removed, u32 removed_count, const Row* added, u32 added_count) {
    static_assert(sizeof(RowChanges) % alignof(Row) == 0);
    auto* out = static_cast<RowChanges*>(scratch(e, sizeof(RowChanges) + u64{removed_count + added_count} * sizeof(Row)));
    *out = {nullptr, removed_count, added_count, 0, 0};
    Row* rows = reinterpret_cast<Row*>(out + 1);
    for (u32 i = 0; i < removed_count; ++i) rows[i] = removed[i];
    for (u32 i = 0; i < added_count; ++i) rows[removed_count + i] = added[i];
    return out;
}

template <class T>
bool same_row(const typename T::Row& a, const typename T::Row& b) {
    if constexpr (T::kRanked)
        if (a.rank != b.rank) return false;
    return T::same(a, b);
}

// The changes in this evaluation. Both lists of rows are sorted by group.
template <class T>
[[gnu::noinline]] const RowChanges* own_changes(Eval& e, Relation<T>& r) {
    using Row = typename T::Row;
    if (r.changes != nullptr) return r.changes;
    KERNEL_CHECK(e, one_a_group<T>(r.rows, r.count));
    KERNEL_CHECK(e, one_a_group<T>(r.origin, r.origin_count));
    RowList<Row> removed, added;
    removed.reset();
    added.reset();
    u32 a = 0, b = 0;
    while (a < r.origin_count || b < r.count) {
        const int side = a == r.origin_count ? 1 : b == r.count ? -1 : T::key(r.origin[a], r.rows[b]);
        if (side != 0 || !same_row<T>(r.origin[a], r.rows[b])) {
            if (side <= 0) removed.add(e, r.origin[a]);
            if (side >= 0) added.add(e, r.rows[b]);
        }
        a += side <= 0;
        b += side >= 0;
    }
    KERNEL_CHECK(e, r.origin_count - removed.count + added.count == r.count);
    return r.changes = new_changes(e, removed.rows, removed.count, added.rows, added.count);
}

// The groups of T that changed rows can affect, and the candidates of each.
template <class T>
struct AffectedGroups {
    using Row = typename T::Row;
    RowList<Row> groups;
    u32* first;  // The first candidate of each group among the proposals; one more entry for the end.
    u32* at;     // Where each group is among the catom's rows, or would be; after find_places().

    // Places among the catom's rows that were found last, in turn: the neighbours of a catom mostly have the same groups to offer.
    static constexpr u32 kMet = 4;
    u32 met[kMet], met_count;

    AffectedGroups() {
        groups.reset();
        met_count = 0;
    }
    MELD_PART void add(Eval& e, const Row& group) { groups.add(e, group); }

    // Whether a row that a rule derives from a neighbour (now, or no longer: gone) can decide its group otherwise: decide_group() keeps a
    // value unless what supports it goes or something better comes. A group without one may wait for another candidate from now on.
    // False too for a group that was added just before.
    bool concerns(const Relation<T>& r, const Row& offer, bool gone) {
        for (u32 i = groups.count; i > 0 && i + kMet > groups.count; --i)
            if (T::key(groups.rows[i - 1], offer) == 0) return false;
        const u32 at = find(r, offer);
        if (at == r.count) return true;
        const Row& held = r.rows[at];
        return gone ? offer.rank <= held.rank && T::same(offer, held) : T::better(offer, held);
    }
    u32 find(const Relation<T>& r, const Row& group) {
        for (u32 i = 0; i < met_count && i < kMet; ++i)
            if (T::key(r.rows[met[i]], group) == 0) return met[i];
        const u32 at = r.find(group);
        if (at < r.count) met[met_count++ % kMet] = at;
        return at;
    }
    // Groups whose quarantine has ended; groups that changed in the last tick come with them, which is harmless.
    MELD_PART void add_woken(Eval& e, const RowChanges* changes) {
        for (; changes != nullptr; changes = changes->next)
            for (u32 i = 0; i < changes->removed + changes->added + changes->woken; ++i) groups.add(e, rows_in<Row>(changes)[i]);
    }

    // Finds where the groups are at the catom.
    MELD_PART void find_places(Eval& e, const Relation<T>& r) {
        at = static_cast<u32*>(scratch(e, u64{groups.count} * sizeof(u32)));
        KERNEL_CHECK(e, one_a_group<T>(r.rows, r.count));
        for (u32 i = 0; i < groups.count; ++i) at[i] = r.near(groups.rows[i]).at;
    }
    // Asks the processor for the rows of the neighbours near these places, where searches for them begin: one after the other, each search
    // would wait for its first row.
    MELD_PART void ask_around(const Relation<T>& r, const RowsHead* heads, const i32* neighbour, i32 ports) const {
        for (i32 port = 0; port < ports; ++port) {
            if (neighbour[port] < 0) continue;
            const RowsHead& head = heads[neighbour[port]];
            for (u32 i = 0; i < groups.count; ++i)
                __builtin_prefetch(head.data + u64{first_look(head.count, {at[i], r.count})} * sizeof(Row));
        }
    }
    // Sorts the groups and removes duplicates. False: there are so many that evaluating all is cheaper.
    [[gnu::noinline]] bool few(Eval& e, const Relation<T>& r) {
        // Each group is affected by a few neighbours, by the old and the new row; rarely by more.
        if (groups.count > 16 + 2 * r.count) return false;
        sort_rows(e, groups.rows, groups.count, [](const Row& a, const Row& b) { return T::key(a, b) < 0; });
        u32 kept = 0;
        for (u32 i = 0; i < groups.count; ++i)
            if (kept == 0 || T::key(groups.rows[kept - 1], groups.rows[i]) != 0) groups.rows[kept++] = groups.rows[i];
        groups.count = kept;
        first = static_cast<u32*>(scratch(e, u64{kept + 1} * sizeof(u32)));
        return kept <= 2 || kept <= r.count / 2;
    }
};

// Decides the affected groups from their candidates and leaves all others unchanged. Returns whether anything changed.
template <class T, class Decide>
bool decide_affected(Eval& e, Relation<T>& r, const AffectedGroups<T>& affected, const Decide& decide) {
    using Row = typename T::Row;
    RowList<Row> removed, added;
    removed.reset();
    added.reset();
    Row* next = nullptr;
    u32 n = 0, from = 0;
    // Most rows stay, and are copied many at a time.
    const auto copy_until = [&](u32 to) {
        if (to == from) return;
        __builtin_memcpy(next + n, r.rows + from, u64{to - from} * sizeof(Row));
        n += to - from;
        from = to;
    };
    for (u32 i = 0; i < affected.groups.count; ++i) {
        const u32 at = affected.at[i];
        const bool there = at < r.count && T::key(r.rows[at], affected.groups.rows[i]) == 0;
        const Row* current = there ? &r.rows[at] : nullptr;
        Row out;
        const bool holds = decide(current, r.proposed.rows + affected.first[i], affected.first[i + 1] - affected.first[i], out);
        if (holds && current != nullptr && same_row<T>(out, *current)) continue;
        if (!holds && current == nullptr) continue;
        if (next == nullptr) next = static_cast<Row*>(scratch(e, u64{r.count + affected.groups.count} * sizeof(Row)));
        copy_until(at);
        if (current != nullptr) {
            removed.add(e, *current);
            ++from;
        }
        if (holds) {
            added.add(e, out);
            next[n++] = out;
        }
    }
    r.start_round();
    if (next == nullptr) return false;
    copy_until(r.count);
    check_view_limit<T>(e, n, r.rule);
    const bool first = r.rows == r.origin;
    r.replace(next, n);
    if (first) r.changes = new_changes(e, removed.rows, removed.count, added.rows, added.count);
    return true;
}

// combine, needed: as for reduce_group().
template <class T, class Combine = OwnCombine<T>>
[[gnu::noinline]] bool evaluate_affected(Eval& e, Relation<T>& r, const AffectedGroups<T>& affected, const Combine& combine = {},
                                         u32 needed = 0) {
    using Row = typename T::Row;
    return decide_affected<T>(e, r, affected, [&](const Row* current, Row* p, u32 n, Row& out) {
        if constexpr (T::kRanked)
            return decide_group<T>(e, r.predicate, current, p, n, out);
        else {
            sort_candidates<T>(e, p, n);
            return n > 0 && reduce_group<T>(e, current, p, n, combine, needed, out);
        }
    });
}

}  // namespace meld
