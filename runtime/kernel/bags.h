// Facts that are given, not derived: linear ones in a bag, persistent ones in a set that only grows.
#pragma once

#include "runtime/kernel/relation.h"

namespace meld {

// Linear facts: a sorted bag; the lowest fact that fits is matched first.
template <class T>
struct Bag {
    using Row = typename T::Row;
    RowList<Row> list;
    RowList<Row> held;  // Made while a comprehension consumes this bag: they join the bag when it ends.
    u32 rule;           // The rule that a trap names: the first that derives T.
    bool holding;
    bool changed;

    void open(Eval& e, const Row* from, u32 n, u32 first_rule) {
        rule = first_rule;
        list.reset();
        held.reset();
        if (n > 0) {
            // With room for what a rule puts back.
            list.capacity = n + 2;
            list.rows = static_cast<Row*>(scratch(e, u64{list.capacity} * sizeof(Row)));
            for (u32 i = 0; i < n; ++i) list.rows[i] = from[i];
            list.count = n;
        }
        changed = holding = false;
    }
    void hold() { holding = true; }
    void release(Eval& e) {
        holding = false;
        for (u32 i = 0; i < held.count; ++i) insert(e, held.rows[i]);
        held.clear();
    }
    void add(Eval& e, const Row& row) {
        ++e.derivations;
        if (holding)
            held.add(e, row);
        else
            insert(e, row);
    }
    MELD_STEP void insert(Eval& e, const Row& row) {
        list.add(e, row);
        u32 at = list.count - 1;
        while (at > 0 && T::key(row, list.rows[at - 1]) < 0) {
            list.rows[at] = list.rows[at - 1];
            --at;
        }
        list.rows[at] = row;
        changed = true;
        check_fact_limit(e, list.count, rule);
    }
    // Removes the facts at these positions, in any order; `positions` is sorted on the way.
    void remove_all(u32* positions, u32 n) {
        for (u32 i = 1; i < n; ++i)
            for (u32 k = i; k > 0 && positions[k] > positions[k - 1]; --k) {
                const u32 swap = positions[k];
                positions[k] = positions[k - 1];
                positions[k - 1] = swap;
            }
        for (u32 i = 0; i < n; ++i) remove(positions[i]);
    }
    // The shorter side moves: facts are usually consumed from the front, and there may be a hundred thousand.
    void remove(u32 at) {
        if (at < list.count / 2) {
            for (u32 i = at; i > 0; --i) list.rows[i] = list.rows[i - 1];
            ++list.rows;
            --list.capacity;
        } else {
            for (u32 i = at + 1; i < list.count; ++i) list.rows[i - 1] = list.rows[i];
        }
        --list.count;
        changed = true;
    }
};

// Asks the processor for a list of a row that is matched soon: what arrived is in the order of its values, not of memory.
template <class Row>
void fetch_ahead(const RowList<Row>& list, u32 at, ListRef Row::* field) {
    constexpr u32 kAhead = 4;
    if (list.count <= at + kAhead) return;
    const char* const place = reinterpret_cast<const char*>(list.rows[at + kAhead].*field);
    __builtin_prefetch(place);
    __builtin_prefetch(place + 64);
}

// Sends a linear fact as a row of its column.
template <class Row>
void send_row(Eval& e, u32 to, u16 predicate, u16 column, const Row& row) {
    Outgoing& out = e.outgoing[column];
    constexpr u64 size = sent_bytes(sizeof(Row));
    if (static_cast<u64>(out.end - out.next) < size + sizeof to) [[unlikely]]
        return e.host->send_row(&e, to, predicate, &row);
    const SentRow entry = {e.catom, 1};
    __builtin_memcpy(out.next, &entry, sizeof entry);
    __builtin_memcpy(out.next + sizeof entry, &row, sizeof row);
    __builtin_memcpy(out.next + size, &to, sizeof to);
    out.next += size + sizeof to;
    ++out.sent;
}

// A fact that many catoms receive: its entry, and where that ends.
struct Letter {
    u8* entry = nullptr;
    u8* end = nullptr;
};

// The same, where the row is that of the letter: it is written once, if nothing else is sent in between.
template <class Row>
void send_row(Eval& e, u32 to, u16 predicate, u16 column, const Row& row, Letter& letter) {
    Outgoing& out = e.outgoing[column];
    if (out.next == letter.end && static_cast<u64>(out.end - out.next) >= sizeof to) [[likely]] {
        __builtin_memcpy(out.next, &to, sizeof to);
        letter.end = out.next += sizeof to;
        ++reinterpret_cast<SentRow*>(letter.entry)->count;
        ++out.sent;
        return;
    }
    u8* const entry = out.next;
    send_row(e, to, predicate, column, row);
    if (static_cast<u64>(out.next - entry) == sent_bytes(sizeof(Row)) + sizeof to) letter = {entry, out.next};
}

// ColumnInfo::arrange.
template <class T>
void arrange_rows(void* to, const void* before, u32 held_count, u32 count) {
    using Row = typename T::Row;
    Row* const rows = static_cast<Row*>(to);
    Row* const come = rows + held_count;
    for (u32 i = 1; i < count; ++i) {
        const Row row = come[i];
        u32 at = i;
        for (; at > 0 && T::key(row, come[at - 1]) < 0; --at) come[at] = come[at - 1];
        come[at] = row;
    }
    // What has come is never overtaken: as much of it is in place as is taken.
    const Row* const held = static_cast<const Row*>(before);
    u32 h = 0, c = 0;
    while (h < held_count) {
        const bool first = c == count || T::key(come[c], held[h]) >= 0;
        rows[h + c] = first ? held[h] : come[c];
        if (first)
            ++h;
        else
            ++c;
    }
}

// Writes what is left of linear facts without lists: in place, if it stays in its block (RowPool::fits).
template <class Row>
void store_rows(Eval& e, u16 column, const RowList<Row>& list) {
    RowsHead& head = reinterpret_cast<RowsHead*>(e.subdomain->columns[column])[e.catom];
    const bool fits =
        list.count > 0 && list.count <= head.capacity && (list.count * 4 >= head.capacity || head.capacity * sizeof(Row) <= 64);
    if (fits) {
        Row* const rows = reinterpret_cast<Row*>(head.data);
        for (u32 i = 0; i < list.count; ++i) rows[i] = list.rows[i];
        head.count = list.count;
    } else if (list.count == 0 && head.capacity == 0) {
        head = {0, 0, nullptr};
    } else {
        e.host->assign_rows(&e, column, list.rows, list.count);
    }
}

// Persistent facts given by linear rules, messages or the world: a sorted set that only grows.
template <class T>
bool give_base(Eval& e, Relation<T>& r, const typename T::Row& row) {
    if (r.find(row) < r.count) return false;
    ++e.derivations;
    RowList<typename T::Row> next;
    next.reset();
    u32 held = 0;
    while (held < r.count && T::key(r.rows[held], row) < 0) next.add(e, r.rows[held++]);
    next.add(e, row);
    while (held < r.count) next.add(e, r.rows[held++]);
    check_fact_limit(e, next.count, r.rule);
    r.replace(next.rows, next.count);
    return true;
}

}  // namespace meld
