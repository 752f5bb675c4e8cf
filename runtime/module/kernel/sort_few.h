// Sorts the few rows that arrive for a catom at once: mostly one from each neighbour, in any order. The processor would guess half of the
// branches of an insertion wrong, so what is here makes more comparisons, and has no branches.
#pragma once

#include "runtime/module/abi/module_abi.h"

#ifdef __clang__
#define MELD_UNROLLED _Pragma("clang loop unroll(full)")
#else
#define MELD_UNROLLED
#endif

namespace meld {

// Sorts N rows by counting how many are before each.
template <class T, u32 N>
void count_places(typename T::Row* rows) {
    typename T::Row copy[N];
    u32 place[N] = {};
    MELD_UNROLLED
    for (u32 i = 0; i < N; ++i) copy[i] = rows[i];
    MELD_UNROLLED
    for (u32 i = 1; i < N; ++i) {
        MELD_UNROLLED
        for (u32 k = 0; k < i; ++k) {
            const u32 before = T::key(copy[i], copy[k]) < 0;
            place[k] += before;
            place[i] += 1 - before;
        }
    }
    MELD_UNROLLED
    for (u32 i = 0; i < N; ++i) rows[place[i]] = copy[i];
}

// Whether the row type says which argument is the last, and whether those before it are alike in two rows.
template <class T>
constexpr bool kTellsLast = requires { T::kLast; };

template <class Row, class V>
V member_of(V Row::* member);

// None is larger.
template <class V>
constexpr V last_value() {
    if constexpr (V(0.5) != V(0))
        return static_cast<V>(__builtin_inf());
    else
        return static_cast<V>(V(-1) < V(0) ? static_cast<u64>(V(-1)) >> (65 - 8 * sizeof(V)) : ~u64{0});
}

// Batcher's merge exchange: the places to compare, and to exchange if the first is the larger, whatever the values are (Knuth, The Art of
// Computer Programming 3, 5.2.2, algorithm M).
template <u32 N>
struct MergeExchange {
    u8 low[N * N / 2], high[N * N / 2];
    u32 count = 0;

    constexpr MergeExchange() : low(), high() {
        u32 top = 1;
        while (2 * top < N) top *= 2;
        for (u32 p = top; p > 0; p /= 2) {
            u32 q = top, r = 0, d = p;
            for (;;) {
                for (u32 i = 0; i + d < N; ++i) {
                    if ((i & p) != r) continue;
                    low[count] = static_cast<u8>(i);
                    high[count++] = static_cast<u8>(i + d);
                }
                if (q == p) break;
                d = q - p;
                q /= 2;
                r = p;
            }
        }
    }
};

// Sorts up to N rows whose arguments before the last are alike, as those of one round are: only the last ones are compared and exchanged,
// in registers and without branches. If others differ, it does nothing and returns false. Exact: there are N.
template <class T, u32 N, bool Exact>
bool sort_last(typename T::Row* rows, u32 count) {
    using Last = decltype(member_of(T::kLast));
    static constexpr MergeExchange<N> kExchanges;
    constexpr Last kMost = last_value<Last>();
    Last last[N];
    bool alike = true;
    MELD_UNROLLED
    for (u32 i = 0; i < N; ++i) {
        const bool there = Exact || i < count;
        const typename T::Row& row = rows[there ? i : 0];
        alike &= T::alike(rows[0], row);
        last[i] = there ? row.*T::kLast : kMost;
    }
    if (!alike) return false;
    MELD_UNROLLED
    for (u32 i = 0; i < kExchanges.count; ++i) {
        Last& low = last[kExchanges.low[i]];
        Last& high = last[kExchanges.high[i]];
        const Last a = low, b = high;
        low = b < a ? b : a;
        high = b < a ? a : b;
    }
    MELD_UNROLLED
    for (u32 i = 0; i < N; ++i)
        if (Exact || i < count) rows[i].*T::kLast = last[i];
    return true;
}

template <class T, u32 N>
void sort_exactly(typename T::Row* rows) {
    if constexpr (kTellsLast<T>)
        if (sort_last<T, N, true>(rows, N)) return;
    count_places<T, N>(rows);
}

// Sorts a few rows. Short: their comparison is a few instructions, and so is their copy.
template <class T, bool Short>
void sort_few(typename T::Row* rows, u32 count) {
    using Row = typename T::Row;
    if constexpr (Short) {
        if (count == 4) return sort_exactly<T, 4>(rows);
        if (count == 5) return sort_exactly<T, 5>(rows);
        if (count == 6) return sort_exactly<T, 6>(rows);
        if constexpr (kTellsLast<T>)
            if (count > 6 && count <= 12 && sort_last<T, 12, false>(rows, count)) return;
    }
    for (u32 i = 1; i < count; ++i) {
        const Row row = rows[i];
        u32 at = i;
        for (; at > 0 && T::key(row, rows[at - 1]) < 0; --at) rows[at] = rows[at - 1];
        rows[at] = row;
    }
}

}  // namespace meld
