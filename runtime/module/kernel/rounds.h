// Sets that derive each other at one catom, evaluated in rounds (compiler/emit/strata.cpp). Each round derives from what the last one has
// added. A row that is there already is dropped where it is derived, with a hash table; rows are put in order once, when nothing is added
// any more. Included by modules with such strata.
#pragma once

#include "runtime/module/kernel/index.h"

namespace meld {

// From so many bytes on, memory is reserved and given back: in scratch memory, what has grown would be there twice.
#ifdef MELD_CHECKED
constexpr u64 kReserved_bytes = 1 << 12;
#else
constexpr u64 kReserved_bytes = 1 << 20;
#endif

// The rows of T while its stratum is evaluated. Rules see those of the rounds before (Relation::rows); those that they derive follow them.
template <class T>
struct Rounds {
    using Row = typename T::Row;
    RowList<Row> all;
    u32 last;    // Where the rows that the last round has added begin.
    u32* slots;  // By hash a position + 1, or 0; null: all are looked through.
    bool fixed;  // The rows stay where they are: they have as much room as there may be rows.
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
        fixed = false;
        r.rows = nullptr;
        r.count = 0;
    }
    void propose(Eval& e, const Row& row) {
        ++e.derivations;
        if (slots == nullptr) {
            for (u32 i = 0; i < all.count; ++i)
                if (T::key(all.rows[i], row) == 0) return;
            put_last(e, row);
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
    // Rules read those of the rounds before meanwhile, so rows that have their own memory do not move.
    [[gnu::noinline]] void grow(Eval& e) {
        if (u64{all.capacity} * 2 * sizeof(Row) < kReserved_bytes || fixed) return all.grow(e);
        // The limit is looked at after each round.
        constexpr u64 kMostRows = u64{1} << 30;
        const u64 most = 2 * view_limit<T>(e), least = u64{all.capacity} * 2,
                  room = most < least       ? least
                         : most > kMostRows ? kMostRows
                                            : most;
        Row* const rows = static_cast<Row*>(e.host->reserve(&e, room * sizeof(Row)));
        if (rows == nullptr || room < least) return all.grow(e);
        for (u32 i = 0; i < all.count; ++i) rows[i] = all.rows[i];
        all.rows = rows;
        all.capacity = static_cast<u32>(room);
        fixed = true;
    }
    // Memory that is given back; zeroed if it was reserved.
    static void* memory(Eval& e, u64 bytes, bool& zeroed) {
        void* const reserved = bytes < kReserved_bytes ? nullptr : e.host->reserve(&e, bytes);
        zeroed = reserved != nullptr;
        return zeroed ? reserved : scratch(e, bytes);
    }

    static void give_back(Eval& e, void* memory, u64 bytes) {
        if (bytes >= kReserved_bytes) e.host->give_back(&e, memory);
    }

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
        // Nothing is looked for any more.
        if (slots != nullptr) give_back(e, slots, (u64{mask} + 1) * sizeof(u32));
        slots = nullptr;
        bool zeroed = false;
        Row* to = static_cast<Row*>(memory(e, u64{n} * sizeof(Row), zeroed));
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
        give_back(e, to, u64{n} * sizeof(Row));
    }
    static u32 hash_of(const Row& row) { return static_cast<u32>((T::hash(row) * 0x9e3779b97f4a7c15ull) >> 32); }
    void add_waiting(Eval& e) {
        const Waiting& next = ahead[put++ % kAhead];
        add(e, next.row, next.hash);
    }
    void put_last(Eval& e, const Row& row) {
        if (all.count == all.capacity) grow(e);
        all.rows[all.count++] = row;
    }
    void add(Eval& e, const Row& row, u32 hash) {
        u32 at = hash & mask;
        while (slots[at] != 0) {
            if (T::key(all.rows[slots[at] - 1], row) == 0) return;
            at = (at + 1) & mask;
        }
        put_last(e, row);
        slots[at] = all.count;
        if (u64{all.count} * 2 > mask) hash_all(e);
    }
    [[gnu::noinline]] void hash_all(Eval& e) {
        const u32 size = slots == nullptr ? 4 * kCompared : 4 * (mask + 1);
        if (slots != nullptr) give_back(e, slots, (u64{mask} + 1) * sizeof(u32));
        mask = size - 1;
        bool zeroed = false;
        slots = static_cast<u32*>(memory(e, u64{size} * sizeof(u32), zeroed));
        for (u32 i = 0; i < size && !zeroed; ++i) slots[i] = 0;
        for (u32 i = 0; i < all.count; ++i) {
            u32 at = hash_of(all.rows[i]) & mask;
            while (slots[at] != 0) at = (at + 1) & mask;
            slots[at] = i + 1;
        }
    }
};

}  // namespace meld
