// How a rule finds the rows of which it knows some arguments (compiler/plan/passes/indexes.cpp). Either way they come in the order of
// the rows, as if each had been looked at. A table of few rows is looked through.
//
// K describes the arguments of one such search: Row; order(a, b) compares them, where rows are sorted by them first; hash(row) is alike for
// rows in which they are equal.
#pragma once

#include "runtime/module/kernel/bags.h"

namespace meld {

// Up to so many rows are looked through: about where halving them takes as long. Making an index takes about as long as looking through all
// rows so many times. A checked module, which tests run with few facts, has indexes at once.
#ifdef MELD_CHECKED
constexpr u32 kScannedRows = 2, kScansBefore = 1;
#else
constexpr u32 kScannedRows = 16, kScansBefore = 4;
#endif

// The rows from first to before end.
struct Span {
    u32 first, end;
};

// Of sorted rows those that begin like `group`. Cost: the logarithm of count.
template <class K>
[[gnu::noinline]] Span find_span(const typename K::Row* rows, u32 count, const typename K::Row& group) {
    // Without a branch on how they compare: nothing foretells it.
    const typename K::Row* at = rows;
    for (u32 n = count; n > 1;) {
        const u32 half = n / 2;
        at = K::order(at[half - 1], group) < 0 ? at + half : at;
        n -= half;
    }
    const u32 low = static_cast<u32>(at - rows) + (count > 0 && K::order(*at, group) < 0 ? 1 : 0);
    // There are mostly few: their end is looked for in growing steps.
    u32 end = low, step = 1;
    while (end + step <= count && K::order(rows[end + step - 1], group) == 0) {
        end += step;
        step *= 2;
    }
    for (; step > 0; step /= 2)
        if (end + step <= count && K::order(rows[end + step - 1], group) == 0) end += step;
    return {low, end};
}
template <class K>
Span span_of(const typename K::Row* rows, u32 count, const typename K::Row& group) {
    if (count <= kScannedRows) return {0, count};
    return find_span<K>(rows, count, group);
}

// Positions in a table, in order: those with one hash, or all.
struct Found {
    u32 first = 0;
    u32* next = nullptr;  // By position the next with this hash, or kNone32; null: all are looked at.

    u32 after(u32 at) const { return next == nullptr ? at + 1 : next[at]; }
    // The same without those that are taken, which are left out from now on: each is met once.
    u32 start(u32 count, const Taken& taken) const {
        if (next == nullptr) return taken.from(0);
        u32 at = first;
        while (at < count && taken.has(at)) at = next[at];
        return at;
    }
    u32 after(u32 at, u32 count, const Taken& taken) const {
        if (next == nullptr) return taken.from(at + 1);
        u32 to = next[at];
        while (to < count && taken.has(to)) to = next[to];
        return next[at] = to;
    }
};

// An index of the rows that a catom holds, for one evaluation: it is made when these rows have been looked through a few times. 8 to 12
// bytes a row in scratch memory.
template <class K>
struct Index {
    using Row = typename K::Row;
    const Row* of = nullptr;  // Of these rows.
    u32 count = 0;
    u32 scans = 0;
    u32 mask = 0, room = 0;
    u32* first = nullptr;  // By hash the first position, or kNone32; null: not made yet.
    u32* next = nullptr;

    void reset() {
        of = nullptr;
        first = nullptr;
    }
    Found find(Eval& e, const Row* rows, u32 n, const Row& group) {
        if (n <= kScannedRows) return {};
        return search(e, rows, n, group);
    }
    [[gnu::noinline]] Found search(Eval& e, const Row* rows, u32 n, const Row& group) {
        if (rows != of || n != count) {
            of = rows;
            count = n;
            scans = 0;
            first = nullptr;
        }
        if (first == nullptr) {
            if (++scans <= kScansBefore) return {};
            make(e, n);
        }
        return {first[slot(group)], next};
    }
    // Of a set to which rows are added at the end: the index grows with it. The rows found are in any order.
    Found find_among_more(Eval& e, const Row* rows, u32 n, const Row& group) {
        if (n <= kScannedRows) return {};
        if (first == nullptr || of == nullptr || n > room) {
            room = n * 2;
            of = rows;
            count = n;
            make(e, room);
        }
        of = rows;
        for (; count < n; ++count) add(count);
        return {first[slot(group)], next};
    }
    // Of those in a bag from which some are taken: they no longer count.
    Found find(Eval& e, const Row* rows, u32 n, const Row& group, const Taken& taken) {
        Found found = find(e, rows, n, group);
        if (found.next != nullptr) first[slot(group)] = found.first = found.start(n, taken);
        return found;
    }

  private:
    u32 slot(const Row& row) const {
        const u64 h = K::hash(row) * 0x9e3779b97f4a7c15ull;
        return static_cast<u32>(h >> 32) & mask;
    }
    void make(Eval& e, u32 rows) {
        u32 slots = 32;
        while (slots < rows) slots *= 2;
        mask = slots - 1;
        first = static_cast<u32*>(scratch(e, u64{slots} * sizeof(u32)));
        next = static_cast<u32*>(scratch(e, u64{rows} * sizeof(u32)));
        for (u32 i = 0; i < slots; ++i) first[i] = kNone32;
        // From the last one, so that each chain is in order.
        for (u32 i = count; i-- > 0;) add(i);
    }
    void add(u32 at) {
        u32& head = first[slot(of[at])];
        next[at] = head;
        head = at;
    }
};

}  // namespace meld
