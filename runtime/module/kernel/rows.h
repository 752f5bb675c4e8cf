// Rows in scratch memory, their order, and how the candidates of a group become one row.
//
// T describes a predicate: Row (plain data, with `rank` if kRanked and `from`, the ports of the neighbours it comes from, if kWaits),
// key(a, b) orders the group, better(a, b) the aggregated value, same(a, b) compares everything but the rank, before(a, b) is the last
// tie-break, hash(row) names the group, combine(e, rows, n, out) reduces all rows to one value.
#pragma once

#include "runtime/module/kernel/check.h"
#include "runtime/module/kernel/library.h"

// Marks the smaller parts of which the rules of a very long module have one copy, instead of one for each place that uses it.
#ifndef MELD_PART
#define MELD_PART
#endif

namespace meld {

// ---- rows in scratch memory

template <class Row>
struct RowList {
    Row* rows;
    u32 count, capacity;

    void clear() { count = 0; }
    void reset() {
        rows = nullptr;
        count = capacity = 0;
    }
    void add(Eval& e, const Row& row) {
        if (count == capacity) grow(e);
        KERNEL_CHECK(e, rows != nullptr && count < capacity);
        rows[count++] = row;
    }
    [[gnu::noinline]] void grow(Eval& e) {
        const u32 more = capacity == 0 ? 16 : capacity * 2;
        Row* bigger = static_cast<Row*>(scratch(e, u64{more} * sizeof(Row)));
        for (u32 i = 0; i < count; ++i) bigger[i] = rows[i];
        rows = bigger;
        capacity = more;
    }
};

// Of a length that is known beforehand, a copy is a few instructions.
inline void copy_row(u8* to, const u8* from, u32 size) {
    switch (size) {
        case 4:
            __builtin_memcpy(to, from, 4);
            break;
        case 8:
            __builtin_memcpy(to, from, 8);
            break;
        case 12:
            __builtin_memcpy(to, from, 12);
            break;
        case 16:
            __builtin_memcpy(to, from, 16);
            break;
        case 24:
            __builtin_memcpy(to, from, 24);
            break;
        default:
            __builtin_memcpy(to, from, size);
    }
}

// Merge sort of the runs that are there: what a catom derives from each neighbour is mostly in order already. Shorter runs than kLeastRun
// are lengthened row by row, so the cost does not depend on the input by more than a constant factor. Stable. One copy serves all row
// types: a module of twenty predicates compiles in half the time. A template, so that one piece of a module can have it for all.
template <u32 = 0>
[[gnu::noinline]] void sort_bytes(Eval& e, u8* rows, u32 count, u32 size, bool (*less)(const void*, const void*)) {
    constexpr u32 kLeastRun = 8;
    u32 sorted = 1;
    while (sorted < count && !less(rows + u64{sorted} * size, rows + u64{sorted - 1} * size)) ++sorted;
    if (sorted >= count) return;
    u32* const ends = static_cast<u32*>(scratch(e, (u64{count} / kLeastRun + 1) * sizeof(u32)));
    u8* from = rows;
    u8* to = static_cast<u8*>(scratch(e, u64{count} * size));
    u32 runs = 0;
    for (u32 begin = 0; begin < count; begin = ends[runs++] = sorted) {
        if (begin == sorted) ++sorted;
        while (sorted < count && !less(rows + u64{sorted} * size, rows + u64{sorted - 1} * size)) ++sorted;
        for (; sorted < count && sorted - begin < kLeastRun; ++sorted) {
            u8* place = rows + u64{sorted} * size;
            copy_row(to, place, size);
            for (; place > rows + u64{begin} * size && less(to, place - size); place -= size) copy_row(place, place - size, size);
            copy_row(place, to, size);
        }
    }
    while (runs > 1) {
        u32 merged = 0;
        for (u32 run = 0, low = 0; run < runs; run += 2) {
            const u32 middle = ends[run], high = run + 1 < runs ? ends[run + 1] : middle;
            const u8 *a = from + u64{low} * size, *b = from + u64{middle} * size;
            const u8 *const a_end = b, *const b_end = from + u64{high} * size;
            u8* next = to + u64{low} * size;
            for (; a < a_end && b < b_end; next += size) {
                const bool right = less(b, a);
                copy_row(next, right ? b : a, size);
                (right ? b : a) += size;
            }
            __builtin_memcpy(next, a, static_cast<u64>(a_end - a));
            __builtin_memcpy(next + (a_end - a), b, static_cast<u64>(b_end - b));
            ends[merged++] = low = high;
        }
        runs = merged;
        u8* const swap = from;
        from = to;
        to = swap;
    }
    if (from != rows) __builtin_memcpy(rows, from, u64{count} * size);
}

// Mostly there is a candidate from each neighbour: these are inserted one by one, where a copy of a row is a few moves.
constexpr u32 kInsertedRows = 12;

template <class Row, class Less>
void sort_rows(Eval& e, Row* rows, u32 count, Less) {
    bool (*const less)(const void*, const void*) = [](const void* a, const void* b) {
        return Less{}(*static_cast<const Row*>(a), *static_cast<const Row*>(b));
    };
    if (count > kInsertedRows) {
        sort_bytes(e, reinterpret_cast<u8*>(rows), count, sizeof(Row), less);
        KERNEL_CHECK(e, in_order(rows, count, Ties::Allowed, Less{}));
        return;
    }
    for (u32 i = 1; i < count; ++i) {
        if (!less(&rows[i], &rows[i - 1])) continue;
        const Row row = rows[i];
        u32 to = i;
        do rows[to] = rows[to - 1];
        while (--to > 0 && less(&row, &rows[to - 1]));
        rows[to] = row;
    }
    KERNEL_CHECK(e, in_order(rows, count, Ties::Allowed, Less{}));
}

// How the candidates of a group become its value: one of them is chosen, or all are combined, either in the order of derivation, which no
// partition changes, or in the order of their values.
enum class Reduce : u8 { Set, Best, First, Since, Combine, CombineInOrder };

// The first of sorted rows from `low` to before `high` that is not before the group, or high.
template <class T>
u32 lower_row(const typename T::Row* rows, u32 low, u32 high, const typename T::Row& group) {
    while (low < high) {
        const u32 middle = low + (high - low) / 2;
        if (T::key(rows[middle], group) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

// The row of a group among sorted rows, or count.
template <class T>
u32 find_row(const typename T::Row* rows, u32 count, const typename T::Row& group) {
    const u32 at = lower_row<T>(rows, 0, count, group);
    return at < count && T::key(rows[at], group) == 0 ? at : count;
}

// Where a group is among the rows of a catom: before the row `at` of so many. Neighbours hold mostly the same groups.
struct Near {
    u32 at, of;
};

// Among so many rows of a neighbour, the one to begin with; 0 if there is none.
inline u32 first_look(u32 count, Near near) {
    const u64 at = near.of == 0 ? 0 : u64{near.at} * count / near.of;
    return at < count ? static_cast<u32>(at) : count == 0 ? 0 : count - 1;
}

// Asks the processor for the rows that a search by halves looks at first, whatever it looks for. In a few lines of the cache there is
// nothing to gain.
inline void ask_for_halves(const RowsHead& head, u32 row_bytes) {
    if (u64{head.count} * row_bytes <= 256) return;
    for (u32 part = 1; part < 8; ++part) __builtin_prefetch(head.data + u64{head.count} * part / 8 * row_bytes);
}

// The same among a neighbour's rows. The search begins where the catom itself has the group and moves away in growing steps: rows of many
// catoms are not in the cache, and this touches fewer lines of it.
template <class T>
MELD_PART u32 find_row(const typename T::Row* rows, u32 count, const typename T::Row& group, Near near) {
    if (count == 0) return 0;
    u32 at = first_look(count, near);
    u32 low = 0, high = count;
    if (T::key(rows[at], group) < 0) {
        u32 step = 1;
        for (low = at + 1; low + step < count && T::key(rows[low + step - 1], group) < 0; step *= 2) low += step;
        if (low + step < count) high = low + step;
    } else {
        u32 step = 1;
        for (high = at + 1; high > step && T::key(rows[high - 1 - step], group) >= 0; step *= 2) high -= step;
        if (high > step) low = high - step;
    }
    at = lower_row<T>(rows, low, high, group);
    return at < count && T::key(rows[at], group) == 0 ? at : count;
}

// The first fact of a catom in a table of facts by catom, or the number of facts.
template <u32 N, u32 Words>
u32 first_fact(const u64 (&facts)[N][Words], u64 catom) {
    u32 low = 0, high = N;
    while (low < high) {
        const u32 middle = low + (high - low) / 2;
        if (facts[middle][0] < catom)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

// By group, then the better value, then the lower rank, then the lower values: the first row of a group is the chosen one.
template <class T>
struct ChoiceOrder {
    bool operator()(const typename T::Row& a, const typename T::Row& b) const {
        if (const int k = T::key(a, b)) return k < 0;
        if (T::better(a, b)) return true;
        if (T::better(b, a)) return false;
        if constexpr (T::kRanked)
            if (a.rank != b.rank) return a.rank < b.rank;
        return T::before(a, b);
    }
};

// Call it before reduce_group(). Without a key all are of one group, of which only the first matters.
template <class T>
void sort_candidates(Eval& e, typename T::Row* rows, u32 n) {
    using Row = typename T::Row;
    if constexpr (T::kReduce == Reduce::CombineInOrder || (T::kKeyed && T::kReduce != Reduce::Combine)) {
        sort_rows(e, rows, n, ChoiceOrder<T>{});
    } else if constexpr (T::kKeyed) {
        sort_rows(e, rows, n, [](const Row& a, const Row& b) { return T::key(a, b) < 0; });
    } else if constexpr (T::kReduce != Reduce::Combine) {
        if (n < 2) return;
        const Row before = rows[0];
        u32 first = 0;
        for (u32 i = 1; i < n; ++i)
            if (ChoiceOrder<T>{}(rows[i], rows[first])) first = i;
        rows[0] = rows[first];
        rows[first] = before;
    }
}

// The combination of T itself. A combination by a function of the program is an argument.
template <class T>
struct OwnCombine {
    void operator()(Eval& e, const typename T::Row* rows, u32 n, typename T::Row& out) const { T::combine(e, rows, n, out); }
};
// T serves several predicates, so the rule that a trap names is given.
template <class T>
    requires(T::kNamesRule)
struct OwnCombine<T> {
    u32 rule;
    void operator()(Eval& e, const typename T::Row* rows, u32 n, typename T::Row& out) const { T::combine(e, rule, rows, n, out); }
};

// Reduces the candidates of one group, at least one, to its row. `held` is the group's previous row, or null; `needed` has a bit for the
// port of each neighbour that must be among those the candidates come from. Returns whether the group holds: a combination without a value
// leaves it empty.
template <class T, class Combine>
bool reduce_group(Eval& e, const typename T::Row* held, const typename T::Row* rows, u32 n, const Combine& combine, u32 needed,
                  typename T::Row& out) {
    KERNEL_CHECK(e, n > 0);
    KERNEL_CHECK(e, of_one_group<T>(rows, n));
    KERNEL_CHECK(e, held == nullptr || T::key(*held, rows[0]) == 0);
    if constexpr (T::kWaits) {
        u32 heard = 0;
        for (u32 i = 0; i < n; ++i) heard |= rows[i].from;
        if ((needed & ~heard) != 0) return false;
    }
    out = rows[0];
    if constexpr (T::kReduce == Reduce::Combine || T::kReduce == Reduce::CombineInOrder) {
        combine(e, rows, n, out);
        if (!defined(e)) return false;
    }
    if constexpr (T::kReduce == Reduce::Since)
        if (held != nullptr) out = *held;
    // A chosen value stays while something supports it.
    if constexpr (T::kReduce == Reduce::First)
        for (u32 i = 0; i < n; ++i)
            if (held != nullptr && T::same(*held, rows[i])) out = rows[i];
    if constexpr (T::kWaits) out.from = 0;
    return true;
}

}  // namespace meld
