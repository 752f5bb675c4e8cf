// Sets that derive each other at one catom, evaluated in rounds (compiler/emit/strata.cpp). Each round derives from what the last one has
// added. A row that is there already is dropped where it is derived, with a hash table; rows are put in order once, when nothing is added
// any more. Included by modules with such strata.
#pragma once

#include "runtime/module/kernel/bitmaps.h"
#include "runtime/module/kernel/index.h"

namespace meld {

// From so many rows on, those whose group is ints are sorted by counting.
#ifdef MELD_CHECKED
constexpr u32 kCountedRows = 16;
#else
constexpr u32 kCountedRows = 1 << 12;
#endif
// Positions in a set, and twice as many slots of its table, are 32 bits.
constexpr u32 kMostRows = u32{1} << 30;

// Where the rows end that are like the first one in the arguments of K.
template <class K>
u32 end_of_alike(const typename K::Row* rows, u32 first, u32 count) {
    u32 end = first + 1;
    while (end < count && K::order(rows[first], rows[end]) == 0) ++end;
    return end;
}

// A merge sort for this type alone: of many rows, a call for each comparison would take most of the time. Returns which of the two places
// has the rows; so few are sorted where they are.
constexpr u32 kSortedInPlace = 8;
template <class T>
[[gnu::noinline]] typename T::Row* merge_sort(typename T::Row* from, typename T::Row* to, u32 n) {
    using Row = typename T::Row;
    constexpr u32 kRun = kSortedInPlace;
    for (u32 low = 0; low < n; low += kRun)
        for (u32 i = low + 1; i < low + kRun && i < n; ++i) {
            const Row row = from[i];
            u32 at = i;
            for (; at > low && T::key(row, from[at - 1]) < 0; --at) from[at] = from[at - 1];
            from[at] = row;
        }
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
    return from;
}

// Rows that a set is asked for by all arguments but the last.
template <class T>
struct Among {
    typename T::Row row;
    typename Bitmaps<T>::Values values;
    const typename T::Row* rows = nullptr;  // Null: values tells them.
    u32 at = 0, count = 0;
    Found found;

    // The next one; false: there are no more.
    bool next() {
        if (rows == nullptr) return values.next(row);
        if (at >= count) return false;
        row = rows[at];
        at = found.after(at);
        return true;
    }
};

// The rows of T while its stratum is evaluated. Rules see those of the rounds before (Relation::rows); those that they derive follow them.
template <class T>
struct Rounds {
    using Row = typename T::Row;
    RowList<Row> all;
    u32 last;         // Where the rows that the last round has added begin.
    u32 visible;      // How many rows rules see.
    Bitmaps<T> maps;  // Tell which rows are there, if they are used, and otherwise
    u32* slots;       // by hash a position + 1, or 0; null: all are looked through.
    bool fixed;       // The rows stay where they are: they have as much room as there may be rows.
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
    u32 come, put;    // How many have waited, and how many no longer do.
    Row* kinds_rows;  // Memory for kinds(), with room for
    u32 kinds_room;   // so many.

    void start(Relation<T>& r) {
        all.reset();
        kinds_rows = nullptr;
        last = visible = come = put = 0;
        maps.start();
        slots = nullptr;
        fixed = false;
        r.rows = nullptr;
        r.count = 0;
    }
    void propose(Eval& e, const Row& row) {
        ++e.derivations;
        if (maps.used) return add_to_maps(e, row);
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
        if (come - put == kAhead) {
            add_waiting(e);
            if (maps.used) return add_to_maps(e, row);
        }
        ahead[come++ % kAhead] = {row, hash};
        if (come - put > kAhead / 2)
            if (const u32 there = slots[ahead[(come - kAhead / 2) % kAhead].hash & mask]) __builtin_prefetch(&all.rows[there - 1]);
    }
    // Whether a row is among those that rules see.
    bool sees(const Row& row) {
        if (maps.used) return maps.sees(row);
        if (slots == nullptr) {
            u32 at = 0;
            while (at < visible && T::key(all.rows[at], row) != 0) ++at;
            return at < visible;
        }
        for (u32 at = hash_of(row) & mask; slots[at] != 0; at = (at + 1) & mask)
            if (T::key(all.rows[slots[at] - 1], row) == 0) return slots[at] <= visible;
        return false;
    }
    // The rows that rules see and that are like this one in all arguments but the last; in the index, also others with its hash.
    template <class K>
    Among<T> among(Eval& e, Index<K>& index, const Relation<T>& r, const Row& row) {
        Among<T> result;
        result.row = row;
        if constexpr (requires { T::kWords; })
            if (maps.used) {
                result.values = maps.values(row);
                return result;
            }
        result.rows = r.rows;
        result.count = r.count;
        result.found = index.find_among_more(e, r.rows, r.count, row);
        result.at = result.found.first;
        return result;
    }
    // The rows of the last round, those that are alike in the arguments of K next to each other; few rows stay as they are. Until kinds are
    // asked for again.
    template <class K>
    const Row* kinds(Eval& e) {
        const u32 count = visible - last;
        if (count <= kScannedRows) return all.rows + last;
        return by_kind<K>(e, all.rows + last, count);
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
        r.count = visible = all.count;
        maps.end_round(e);
        if (maps.used)
            for (u32 i = last; i < visible; ++i) maps.see(all.rows[i]);
        return visible > last;
    }
    // Ends the evaluation: returns whether the facts differ from before.
    [[gnu::noinline]] bool finish(Eval& e, Relation<T>& r, const Row* before, u32 before_count) {
        sort_all(e);
        KERNEL_CHECK(e, one_a_group<T>(all.rows, all.count));
        r.rows = all.rows;
        r.count = all.count;
        const bool differs = r.end_rounds(before, before_count);
        // One of both is not needed any more: linear rules may bring views to their fixpoint many times.
        if (!differs)
            give_back(e, all.rows, u64{all.count} * sizeof(Row));
        else if (u64{before_count} * sizeof(Row) >= kReserved_bytes)
            e.host->empty(&e, const_cast<Row*>(before));
        return differs;
    }

  private:
    // Rules read those of the rounds before meanwhile, so rows that have their own memory do not move.
    [[gnu::noinline]] void grow(Eval& e) {
        if (u64{all.capacity} * 2 * sizeof(Row) < kReserved_bytes || fixed) return all.grow(e);
        // The limit is looked at after each round.
        const u64 most = 2 * view_limit<T>(e), least = u64{all.capacity} * 2,
                  room = most < least       ? least
                         : most > kMostRows ? kMostRows
                                            : most;
        Row* const rows = static_cast<Row*>(e.host->reserve(&e, room * sizeof(Row), least * sizeof(Row)));
        if (rows == nullptr || room < least) return all.grow(e);
        for (u32 i = 0; i < all.count; ++i) rows[i] = all.rows[i];
        all.rows = rows;
        all.capacity = static_cast<u32>(room);
        fixed = true;
    }
    template <class K>
    [[gnu::noinline]] const Row* by_kind(Eval& e, const Row* rows, u32 count) {
        if (kinds_rows == nullptr || kinds_room < count) {
            if (kinds_rows != nullptr) give_back(e, kinds_rows, u64{kinds_room} * sizeof(Row));
            bool zeroed = false;
            kinds_room = count * 2;
            kinds_rows = static_cast<Row*>(lent(e, u64{kinds_room} * sizeof(Row), zeroed));
        }
        u8 *const arena = e.arena, *const chunk = e.arena_start;
        u64 size = 32;
        while (size < u64{count} * 2) size *= 2;
        u32* const table = static_cast<u32*>(scratch(e, size * sizeof(u32)));  // By hash a kind + 1, or 0.
        u32* const kind = static_cast<u32*>(scratch(e, u64{count} * sizeof(u32)));
        u32* const first = static_cast<u32*>(scratch(e, u64{count} * sizeof(u32)));  // By kind.
        u32* const place =
            static_cast<u32*>(scratch(e, u64{count} * sizeof(u32)));  // By kind: how many there are, then where the next goes.
        __builtin_memset(table, 0, size * sizeof(u32));
        u32 kinds = 0;
        for (u32 i = 0; i < count; ++i) {
            if (i > 0 && K::order(rows[i - 1], rows[i]) == 0) {
                kind[i] = kind[i - 1];
            } else {
                u64 slot = (K::hash(rows[i]) * 0x9e3779b97f4a7c15ull >> 32) & (size - 1);
                while (table[slot] != 0 && K::order(rows[first[table[slot] - 1]], rows[i]) != 0) slot = (slot + 1) & (size - 1);
                if (table[slot] == 0) {
                    first[kinds] = i;
                    place[kinds] = 0;
                    table[slot] = ++kinds;
                }
                kind[i] = table[slot] - 1;
            }
            ++place[kind[i]];
        }
        u32 from = 0;
        for (u32 k = 0; k < kinds; ++k) {
            const u32 there = place[k];
            place[k] = from;
            from += there;
        }
        for (u32 i = 0; i < count; ++i) kinds_rows[place[kind[i]]++] = rows[i];
        // Rows in order lead to bits in order.
        if constexpr (requires { T::kWords; }) {
            Row* const spare = static_cast<Row*>(scratch(e, u64{count} * sizeof(Row)));
            for (u32 k = 0, begin = 0; k < kinds; begin = place[k++]) {
                const u32 there = place[k] - begin;
                if (there < 3) continue;
                const Row* const sorted = merge_sort<T>(kinds_rows + begin, spare, there);
                if (sorted == spare) __builtin_memcpy(kinds_rows + begin, spare, u64{there} * sizeof(Row));
            }
        }
        // All of this is free again, unless it needed another chunk.
        if (e.arena_start == chunk) e.arena = arena;
        return kinds_rows;
    }

    void sort_all(Eval& e) {
        if (all.count < 2) return;
        // Nothing is looked for any more.
        maps.end(e);
        maps.end_round(e);
        if (kinds_rows != nullptr) give_back(e, kinds_rows, u64{kinds_room} * sizeof(Row));
        kinds_rows = nullptr;
        if (slots != nullptr) give_back(e, slots, (u64{mask} + 1) * sizeof(u32));
        slots = nullptr;
        if constexpr (requires { T::kWords; })
            if (all.count >= kCountedRows && count_sort(e)) return;
        bool zeroed = false;
        const u64 bytes = u64{all.count} * sizeof(Row);
        Row *const here = all.rows, *const there = all.count <= kSortedInPlace ? nullptr : static_cast<Row*>(lent(e, bytes, zeroed));
        all.rows = merge_sort<T>(here, there, all.count);
        if (there != nullptr) give_back(e, all.rows == here ? there : here, bytes);
    }

    // By digits of the words that make the group, the last ones first; digits that are 0 in all rows, after the least value has been taken
    // away, are left out. False, and nothing is changed, if there are so many digits that comparing takes less.
    bool count_sort(Eval& e) {
        constexpr u32 kDigit_bits = 11, kMostPasses = 8;
        const u32 n = all.count;
        u64 least[T::kWords];
        u32 passes[T::kWords], bits[T::kWords], sum = 0;
        for (u32 w = 0; w < T::kWords; ++w) {
            u64 most = least[w] = T::word(all.rows[0], w);
            for (u32 i = 1; i < n; ++i) {
                const u64 value = T::word(all.rows[i], w);
                if (value < least[w]) least[w] = value;
                if (value > most) most = value;
            }
            const u32 used = most == least[w] ? 0 : 64 - static_cast<u32>(__builtin_clzll(most - least[w]));
            passes[w] = (used + kDigit_bits - 1) / kDigit_bits;
            bits[w] = passes[w] == 0 ? 0 : (used + passes[w] - 1) / passes[w];
            sum += passes[w];
        }
        if (sum > kMostPasses) return false;
        bool zeroed = false;
        Row* from = all.rows;
        Row* to = static_cast<Row*>(lent(e, u64{n} * sizeof(Row), zeroed));
        for (u32 w = T::kWords; w-- > 0;)
            for (u32 pass = 0; pass < passes[w]; ++pass) {
                const u32 shift = pass * bits[w], digits = u32{1} << bits[w];
                const auto digit = [&](const Row& row) { return static_cast<u32>((T::word(row, w) - least[w]) >> shift) & (digits - 1); };
                u32 next[u32{1} << kDigit_bits] = {};
                for (u32 i = 0; i < n; ++i) ++next[digit(from[i])];
                u32 before = 0;
                for (u32 d = 0; d < digits; ++d) {
                    const u32 here = next[d];
                    next[d] = before;
                    before += here;
                }
                for (u32 i = 0; i < n; ++i) to[next[digit(from[i])]++] = from[i];
                Row* const swap = from;
                from = to;
                to = swap;
            }
        all.rows = from;
        give_back(e, to, u64{n} * sizeof(Row));
        return true;
    }

    static u32 hash_of(const Row& row) { return static_cast<u32>((T::hash(row) * 0x9e3779b97f4a7c15ull) >> 32); }
    void add_waiting(Eval& e) {
        const Waiting& next = ahead[put++ % kAhead];
        if (maps.used) return add_to_maps(e, next.row);
        add(e, next.row, next.hash);
    }
    void add_to_maps(Eval& e, const Row& row) {
        if (!maps.has(row)) add_new(e, row);
    }
    [[gnu::noinline]] void add_new(Eval& e, const Row& row) {
        if (!put_last(e, row) || maps.add(e, row, all.count)) return;
        if (!maps.make(e, all.rows, all.count, visible)) hash_all(e);
    }
    // False: there are as many as there can be.
    bool put_last(Eval& e, const Row& row) {
        if (all.count == all.capacity) {
            if (all.count >= kMostRows) return trap(e, Trap::TooManyFacts, e.rule, i64{all.count} + 1, i64{kMostRows}), false;
            grow(e);
        }
        all.rows[all.count++] = row;
        return true;
    }
    void add(Eval& e, const Row& row, u32 hash) {
        u32 at = hash & mask;
        while (slots[at] != 0) {
            if (T::key(all.rows[slots[at] - 1], row) == 0) return;
            at = (at + 1) & mask;
        }
        if (!put_last(e, row)) return;
        slots[at] = all.count;
        if (all.count * 2 > mask && all.count < kMostRows) more_slots(e);
    }
    void hash_all(Eval& e) {
        u64 size = slots == nullptr ? 4 * kCompared : 4 * (u64{mask} + 1);
        while (size < u64{all.count} * 2) size *= 4;
        if (slots != nullptr) give_back(e, slots, (u64{mask} + 1) * sizeof(u32));
        mask = static_cast<u32>(size - 1);
        bool zeroed = false;
        slots = static_cast<u32*>(lent(e, size * sizeof(u32), zeroed));
        for (u64 i = 0; i < size && !zeroed; ++i) slots[i] = 0;
        for (u32 i = 0; i < all.count; ++i) {
            u32 at = hash_of(all.rows[i]) & mask;
            while (slots[at] != 0) at = (at + 1) & mask;
            slots[at] = i + 1;
        }
    }
    // More rows than the slots are for.
    [[gnu::noinline]] void more_slots(Eval& e) {
        if (all.count < kRowsForBitmaps || !maps.make(e, all.rows, all.count, visible)) return hash_all(e);
        give_back(e, slots, (u64{mask} + 1) * sizeof(u32));
        slots = nullptr;
    }
};

}  // namespace meld
