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
        const u32 place = find(r, offer);
        if (place == r.count) return true;
        const Row& held = r.rows[place];
        return gone ? offer.rank <= held.rank && T::same(offer, held) : T::better(offer, held);
    }
    u32 find(const Relation<T>& r, const Row& group) {
        for (u32 i = 0; i < met_count && i < kMet; ++i)
            if (T::key(r.rows[met[i]], group) == 0) return met[i];
        const u32 place = r.find(group);
        if (place < r.count) met[met_count++ % kMet] = place;
        return place;
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

// Whether the catom remembers no loss, so that all derivations are trusted, and there are none of a group without a value.
inline bool has_lost_nothing(Eval& e) { return !e.subdomain->tombstones || !e.host->tombstone(&e, kNone16, 0, nullptr); }

// What rules derive from rows that neighbours have gained, each from one row. If nobody has lost anything, neither now nor before, groups
// keep their values unless something better comes, and a group without one gets the best of what comes now: it was offered nothing before.
// So each row of a neighbour is derived from once. Rows mostly come in order from each neighbour: these runs are merged, not sorted.
template <class T>
struct Gains {
    using Row = typename T::Row;
    RowList<Row> rows;   // After merge(): in the order of groups, the best of each group.
    RowList<u32> begun;  // Where runs but the first begin.

    Gains() {
        rows.reset();
        begun.reset();
    }
    // Where up to so many more rows are to be put, followed by end().
    Row* room(Eval& e, u32 more) {
        if (rows.capacity - rows.count < more) grow(e, more);
        return rows.rows + rows.count;
    }
    MELD_PART void end(Eval& e, const Row* to) {
        const u32 count = static_cast<u32>(to - rows.rows);
        KERNEL_CHECK(e, count >= rows.count && count <= rows.capacity);
        e.derivations += count - rows.count;
        for (u32 i = rows.count == 0 ? 1 : rows.count; i < count; ++i)
            if (T::key(rows.rows[i - 1], rows.rows[i]) >= 0) begun.add(e, i);
        rows.count = count;
    }
    // False: the predicate could exceed its limit, so all of it is to be evaluated, which says what does.
    [[gnu::noinline]] bool merge(Eval& e, const Relation<T>& r) {
        if (begun.count > 0 && rows.count <= kFewRows)
            put_in_order();
        else if (begun.count > 0)
            merge_runs(e);
        KERNEL_CHECK(e, one_a_group<T>(rows.rows, rows.count));
        return u64{r.count} + rows.count <= view_limit<T>(e);
    }

  private:
    [[gnu::noinline]] void grow(Eval& e, u32 more) {
        const u32 least = rows.count + more, twice = 2 * rows.capacity < kFewRows ? kFewRows : 2 * rows.capacity;
        const u32 capacity = least < twice ? twice : least;
        Row* const bigger = static_cast<Row*>(scratch(e, u64{capacity} * sizeof(Row)));
        if (rows.count > 0) __builtin_memcpy(bigger, rows.rows, u64{rows.count} * sizeof(Row));
        rows.rows = bigger;
        rows.capacity = capacity;
    }
    // So few rows take fewer instructions to put in their places one by one than to merge.
    static constexpr u32 kFewRows = 16;
    void put_in_order() {
        Row* const at = rows.rows;
        const u32 count = rows.count;
        u32 n = begun.rows[0];
        for (u32 i = n; i < count; ++i) {
            const Row row = at[i];
            u32 place = n;
            int side = 1;
            while (place > 0 && (side = T::key(at[place - 1], row)) > 0) --place;
            if (place > 0 && side == 0) {
                if (comes_first(row, at[place - 1])) at[place - 1] = row;
                continue;
            }
            for (u32 k = n++; k > place; --k) at[k] = at[k - 1];
            at[place] = row;
        }
        rows.count = n;
    }
    // Two by two. Nothing foretells from which run the next row comes, so there is no branch on that.
    void merge_runs(Eval& e) {
        u32 runs = begun.count + 1;
        begun.add(e, rows.count);
        Row* from = rows.rows;
        Row* to = static_cast<Row*>(scratch(e, u64{rows.count} * sizeof(Row)));
        u32 made = 0;
        while (runs > 1) {
            u32 merged = 0, low = 0;
            made = 0;
            for (u32 run = 0; run < runs; run += 2) {
                const u32 middle = begun.rows[run], high = run + 1 < runs ? begun.rows[run + 1] : middle;
                made += merge_two(from + low, from + middle, from + high, to + made);
                begun.rows[merged++] = made;
                low = high;
            }
            runs = merged;
            Row* const swap = from;
            from = to;
            to = swap;
        }
        rows.rows = from;
        rows.count = made;
    }
    static u32 merge_two(const Row* a, const Row* const middle, const Row* const end, Row* const to) {
        const Row* b = middle;
        Row* next = to;
        while (a < middle && b < end) {
            const int side = T::key(*a, *b);
            const Row* const first = (side > 0) | ((side == 0) & comes_first(*b, *a)) ? b : a;
            *next++ = *first;
            a += side <= 0;
            b += side >= 0;
        }
        __builtin_memcpy(next, a, static_cast<u64>(middle - a) * sizeof(Row));
        next += middle - a;
        __builtin_memcpy(next, b, static_cast<u64>(end - b) * sizeof(Row));
        return static_cast<u32>(next + (end - b) - to);
    }
    // Of two rows of a group.
    static bool comes_first(const Row& a, const Row& b) {
        if constexpr (T::kReduce == Reduce::Set)
            return a.rank < b.rank;
        else
            return ChoiceOrder<T>{}(a, b);
    }
};

// Rows of a neighbour that a catom has mostly already, next to so many others that they are looked for one by one.
constexpr u32 kFewGains = 8;

// The gains that enter: those of new groups, and better ones. All: the catom's rows with them, too.
template <class T, bool All>
struct Entering {
    using Row = typename T::Row;
    Eval& e;
    const Relation<T>& r;
    Row* p;   // The gains; then those that enter.
    u32* at;  // Before which of the catom's rows each of them comes, or in whose place.
    u32 count = 0;
    RowList<Row> replaced;
    Row* next;
    u32 made = 0;

    Entering(Eval& eval, const Relation<T>& relation, const Gains<T>& gains)
        : e(eval),
          r(relation),
          p(gains.rows.rows),
          at(static_cast<u32*>(scratch(eval, u64{gains.rows.count} * sizeof(u32)))),
          next(All ? static_cast<Row*>(scratch(eval, (u64{relation.count} + gains.rows.count) * sizeof(Row))) : nullptr) {
        replaced.reset();
    }
    static bool better(const Row& gain, const Row& held) { return T::kReduce != Reduce::Set && T::better(gain, held); }
    void put(const Row& row, u32 place) {
        p[count] = row;
        at[count++] = place;
    }
    void look_for(u32 n) {
        u32 held = 0, from = 0;
        const auto copy_until = [&](u32 to) {
            if (to > from) __builtin_memcpy(next + made, r.rows + from, u64{to - from} * sizeof(Row));
            made += to - from;
            from = to;
        };
        for (u32 i = 0; i < n; ++i) {
            held = lower_row<T>(r.rows, held, r.count, p[i]);
            const bool there = held < r.count && T::key(r.rows[held], p[i]) == 0;
            if (there && !better(p[i], r.rows[held])) continue;
            if (All) copy_until(held);
            if (All) next[made++] = p[i];
            if (there) {
                replaced.add(e, r.rows[held]);
                ++from;
            }
            put(p[i], held);
        }
        if (All && count > 0) copy_until(r.count);
    }
    void go_through(u32 n) {
        u32 held = 0, i = 0;
        while (held < r.count && i < n) {
            const int side = T::key(r.rows[held], p[i]);
            const bool enters = (side > 0) | ((side == 0) && better(p[i], r.rows[held]));
            if constexpr (All) {
                const Row* const row = enters ? &p[i] : &r.rows[held];
                next[made++] = *row;
            }
            if constexpr (T::kReduce != Reduce::Set)
                if (enters && side == 0) replaced.add(e, r.rows[held]);
            p[count] = p[i];
            at[count] = held;
            count += enters;
            held += side <= 0;
            i += side >= 0;
        }
        if (All && held < r.count) {
            __builtin_memcpy(next + made, r.rows + held, u64{r.count - held} * sizeof(Row));
            made += r.count - held;
        }
        for (; i < n; ++i) {
            if (All) next[made++] = p[i];
            put(p[i], held);
        }
    }
    // Of the rows that were there to those that are.
    const RowChanges* changes() const {
        const u32 places = replaced.count == 0 ? count : 0;
        const u64 bytes = (sizeof(RowChanges) + u64{replaced.count + count} * sizeof(Row) + 3) & ~u64{3};
        auto* const out = static_cast<RowChanges*>(scratch(e, bytes + u64{places} * sizeof(u32)));
        *out = {nullptr, replaced.count, count, 0, replaced.count == 0};
        Row* const rows = reinterpret_cast<Row*>(out + 1);
        if (replaced.count > 0) __builtin_memcpy(rows, replaced.rows, u64{replaced.count} * sizeof(Row));
        __builtin_memcpy(rows + replaced.count, p, u64{count} * sizeof(Row));
        if (places > 0) __builtin_memcpy(const_cast<u32*>(places_of(*out, sizeof(Row))), at, u64{places} * sizeof(u32));
        return out;
    }
};

// Takes merged gains; returns whether anything changed. All: something reads the rows later in this evaluation; otherwise only the changes
// are made.
template <bool All, class T>
[[gnu::noinline]] bool take_gains(Eval& e, Relation<T>& r, const Gains<T>& gains) {
    const u32 n = gains.rows.count;
    if (n == 0) return false;
    Entering<T, All> entering(e, r, gains);
    if (u64{n} * kFewGains < r.count)
        entering.look_for(n);
    else
        entering.go_through(n);
    if (entering.count == 0) return false;
    u32 greatest = 0;
    for (u32 i = 0; i < entering.count; ++i)
        if (entering.p[i].rank > greatest) greatest = entering.p[i].rank;
    note_rank(e, greatest);
    KERNEL_CHECK(e, !All || one_a_group<T>(entering.next, entering.made));
    KERNEL_CHECK(e, All || r.rows == r.origin);
    const bool first = r.rows == r.origin;
    if constexpr (All) r.replace(entering.next, entering.made);
    r.changed = true;
    if (first) r.changes = entering.changes();
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
