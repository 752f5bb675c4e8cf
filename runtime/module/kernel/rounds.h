// Sets that derive each other at one catom, evaluated in rounds (compiler/emit/strata.cpp). Each round derives from what the last one has
// added. A row that is there already is dropped where it is derived, with a hash table; rows are put in order once, when nothing is added
// any more. Included by modules with such strata.
#pragma once

#include "runtime/module/kernel/index.h"

namespace meld {

// The rows of T while its stratum is evaluated. Rules see those of the rounds before (Relation::rows); those that they derive follow them.
template <class T>
struct Rounds {
    using Row = typename T::Row;
    RowList<Row> all;
    u32 last;    // Where the rows that the last round has added begin.
    u32* slots;  // By hash a position + 1, or 0; null: all are looked through.
    u32 mask;

    // Rows that are compared with each other one by one.
    static constexpr u32 kCompared = 8;
    // From so many rows on the table is not in the cache: rows wait until what they are compared with has come from memory.
    static constexpr u32 kFar = 4096, kAhead = 16;
    struct Waiting {
        Row row;
        u32 hash;
    };
    Waiting ahead[kAhead];
    u32 come, put;  // How many have waited, and how many no longer do.

    void start(Relation<T>& r) {
        all.reset();
        last = come = put = 0;
        slots = nullptr;
        r.rows = nullptr;
        r.count = 0;
    }
    void propose(Eval& e, const Row& row) {
        ++e.derivations;
        if (slots == nullptr) {
            for (u32 i = 0; i < all.count; ++i)
                if (T::key(all.rows[i], row) == 0) return;
            all.add(e, row);
            if (all.count == kCompared) hash_all(e);
            return;
        }
        const u32 hash = hash_of(row);
        if (all.count < kFar) return add(e, row, hash);
        __builtin_prefetch(&slots[hash & mask]);
        if (come - put == kAhead) add_waiting(e);
        ahead[come++ % kAhead] = {row, hash};
        if (come - put > kAhead / 2)
            if (const u32 there = slots[ahead[(come - kAhead / 2) % kAhead].hash & mask]) __builtin_prefetch(&all.rows[there - 1]);
    }
    // Whether this round has added anything so far.
    bool grew(Eval& e, const Relation<T>& r) {
        while (put != come) add_waiting(e);
        return all.count > r.count;
    }
    // From now on rules see what this round has added; returns whether that is anything.
    bool end_round(Eval& e, Relation<T>& r) {
        while (put != come) add_waiting(e);
        last = r.count;
        r.rows = all.rows;
        r.count = all.count;
        return r.count > last;
    }
    // Ends the evaluation: returns whether the facts differ from before.
    [[gnu::noinline]] bool finish(Eval& e, Relation<T>& r, const Row* before, u32 before_count) {
        sort_all(e);
        KERNEL_CHECK(e, one_a_group<T>(all.rows, all.count));
        r.rows = all.rows;
        r.count = all.count;
        return r.end_rounds(before, before_count);
    }

  private:
    // A merge sort for this type alone: of many rows, a call for each comparison would take most of the time.
    void sort_all(Eval& e) {
        constexpr u32 kRun = 8;
        Row* from = all.rows;
        const u32 n = all.count;
        for (u32 low = 0; low < n; low += kRun)
            for (u32 i = low + 1; i < low + kRun && i < n; ++i) {
                const Row row = from[i];
                u32 to = i;
                for (; to > low && T::key(row, from[to - 1]) < 0; --to) from[to] = from[to - 1];
                from[to] = row;
            }
        if (n <= kRun) return;
        Row* to = static_cast<Row*>(scratch(e, u64{n} * sizeof(Row)));
        for (u32 width = kRun; width < n; width *= 2) {
            for (u32 low = 0; low < n; low += 2 * width) {
                const u32 middle = low + width < n ? low + width : n, high = low + 2 * width < n ? low + 2 * width : n;
                u32 a = low, b = middle, k = low;
                // Without a branch on which side is less: nothing foretells it.
                while (a < middle && b < high) {
                    const bool right = T::key(from[b], from[a]) < 0;
                    to[k++] = from[right ? b : a];
                    b += right;
                    a += !right;
                }
                while (a < middle) to[k++] = from[a++];
                while (b < high) to[k++] = from[b++];
            }
            Row* const swap = from;
            from = to;
            to = swap;
        }
        all.rows = from;
    }
    static u32 hash_of(const Row& row) { return static_cast<u32>((T::hash(row) * 0x9e3779b97f4a7c15ull) >> 32); }
    void add_waiting(Eval& e) {
        const Waiting& next = ahead[put++ % kAhead];
        add(e, next.row, next.hash);
    }
    void add(Eval& e, const Row& row, u32 hash) {
        u32 at = hash & mask;
        while (slots[at] != 0) {
            if (T::key(all.rows[slots[at] - 1], row) == 0) return;
            at = (at + 1) & mask;
        }
        all.add(e, row);
        slots[at] = all.count;
        if (u64{all.count} * 2 > mask) hash_all(e);
    }
    [[gnu::noinline]] void hash_all(Eval& e) {
        const u32 size = slots == nullptr ? 4 * kCompared : 4 * (mask + 1);
        mask = size - 1;
        slots = static_cast<u32*>(scratch(e, u64{size} * sizeof(u32)));
        for (u32 i = 0; i < size; ++i) slots[i] = 0;
        for (u32 i = 0; i < all.count; ++i) {
            u32 at = hash_of(all.rows[i]) & mask;
            while (slots[at] != 0) at = (at + 1) & mask;
            slots[at] = i + 1;
        }
    }
};

}  // namespace meld
