// Facts that are given, not derived: linear ones in a bag, persistent ones in a set that only grows.
#pragma once

#include "runtime/module/kernel/neighbours.h"
#include "runtime/module/kernel/relation.h"
#include "runtime/module/kernel/sort_few.h"

namespace meld {

// Positions in a bag whose facts a rule has taken while its search goes on (compiler/plan/passes/one_search.cpp): the facts stay where they
// are until the search ends, so that positions hold.
struct Taken {
    u32* next = nullptr;  // For each position one at or after it that may not be taken; null: nothing is taken.
    u32 number = 0;

    bool has(u32 at) const { return next != nullptr && next[at] != at; }
    // The first at or after this one that is not taken. Steps over what was taken get longer each time, so a search that begins anew at the
    // front does not visit it again.
    u32 from(u32 at) const {
        if (next == nullptr) return at;
        while (next[at] != at) at = next[at] = next[next[at]];
        return at;
    }
    void take(Eval& e, u32 count, u32 at) {
        if (next == nullptr) {
            next = static_cast<u32*>(scratch(e, (u64{count} + 1) * sizeof(u32)));
            for (u32 i = 0; i <= count; ++i) next[i] = i;
        }
        KERNEL_CHECK(e, at < count && next[at] == at);
        next[at] = at + 1;
        ++number;
    }
};

// Linear facts: a sorted bag; the lowest fact that fits is matched first.
template <class T>
struct Bag {
    using Row = typename T::Row;
#ifdef MELD_CHECKED
    static constexpr u32 kMovedAtOnce = 3;
#else
    static constexpr u32 kMovedAtOnce = 64;
#endif
    RowList<Row> list;
    RowList<Row> held;  // Made while a comprehension consumes this bag: they join the bag when it ends.
    u32 late;           // So many at the end of the list are not in order yet: arrange() is due before it is read.
    u32 rule;           // The rule that a trap names: the first that derives T.
    bool stored;        // The list is where the column has it, and must not be written to. It has no room, so that what is added copies it.
    bool holding;
    bool changed;

    void open(const Row* from, u32 n, u32 first_rule) {
        rule = first_rule;
        list.rows = const_cast<Row*>(from);
        list.count = list.capacity = n;
        held.reset();
        late = 0;
        stored = true;
        changed = holding = false;
    }
    // From here on the list may be written to.
    void own(Eval& e) {
        if (stored) make_room(e);
    }
    void make_room(Eval& e) {
        if (list.count > 0) {
            list.grow(e);
        } else {
            list.capacity = 4;
            list.rows = static_cast<Row*>(scratch(e, 4 * sizeof(Row)));
        }
        stored = false;
    }
    // The bag holds this fact alone.
    void become(Eval& e, const Row& row) {
        list.count = late = 0;
        own(e);
        list.rows[0] = row;
        list.count = 1;
        changed = true;
    }
    void hold() { holding = true; }
    void release(Eval& e) {
        KERNEL_CHECK(e, holding);
        holding = false;
        for (u32 i = 0; i < held.count; ++i) insert(e, held.rows[i]);
        held.clear();
    }
    // Inlined: a row that goes through memory is written field by field and read whole, which waits for the writes.
    [[gnu::always_inline]] void add(Eval& e, const Row& row) {
        ++e.derivations;
        if (holding)
            held.add(e, row);
        else
            insert(e, row);
    }
    [[gnu::always_inline]] void insert(Eval& e, const Row& row) {
        if (list.count == list.capacity) make_room(e);
        KERNEL_CHECK(e, !stored && list.count < list.capacity);
        list.rows[list.count++] = row;
        changed = true;
        if (list.count > 1) move_last(e);
    }
    // Before a rule reads the facts.
    [[gnu::always_inline]] void arrange(Eval& e) {
        if (late > 0) [[unlikely]]
            arrange_late(e);
    }
    [[gnu::noinline]] void arrange_late(Eval& e) {
        const u32 before = list.count - late;
        Row* const come = list.rows + before;
        sort_rows(e, come, late, [](const Row& a, const Row& b) { return T::key(a, b) < 0; });
        Row* const to = static_cast<Row*>(scratch(e, u64{list.count} * sizeof(Row)));
        u32 h = 0, c = 0;
        while (h < before || c < late) {
            const bool first = c == late || (h < before && T::key(come[c], list.rows[h]) >= 0);
            to[h + c] = first ? list.rows[h] : come[c];
            if (first)
                ++h;
            else
                ++c;
        }
        list.rows = to;
        list.capacity = list.count;
        late = 0;
    }
    // The last fact goes where it belongs: at once in a short list, in a long one with all that come before the list is read.
    MELD_STEP void move_last(Eval& e) {
        u32 at = list.count - 1;
        const Row row = list.rows[at];
        if (list.count > kMovedAtOnce) {
            late += late > 0 || T::key(row, list.rows[at - 1]) < 0;
            return check_fact_limit(e, list.count, rule);
        }
        while (at > 0 && T::key(row, list.rows[at - 1]) < 0) {
            list.rows[at] = list.rows[at - 1];
            --at;
        }
        list.rows[at] = row;
        KERNEL_CHECK(e, in_order(list.rows, list.count, Ties::Allowed, [](const Row& a, const Row& b) { return T::key(a, b) < 0; }));
        check_fact_limit(e, list.count, rule);
    }
    // Removes the facts at these positions, in any order; `positions` is sorted on the way.
    void remove_all(Eval& e, u32* positions, u32 n) {
        for (u32 i = 1; i < n; ++i)
            for (u32 k = i; k > 0 && positions[k] > positions[k - 1]; --k) {
                const u32 swap = positions[k];
                positions[k] = positions[k - 1];
                positions[k - 1] = swap;
            }
        KERNEL_CHECK(e, in_order(positions, n, Ties::None, [](u32 a, u32 b) { return a > b; }));
        for (u32 i = 0; i < n; ++i) remove(e, positions[i]);
    }
    // Removes the facts that a search has taken.
    MELD_STEP void drop(Eval& e, const Taken& taken) {
        if (taken.number == 0) return;
        KERNEL_CHECK(e, late == 0);
        const u32 count = list.count, front = taken.from(0);
        changed = true;
        if (front == taken.number) {
            list.rows += front;
            list.count -= front;
            list.capacity -= front;
            return;
        }
        const Row* const before = list.rows;
        if (stored) list.rows = static_cast<Row*>(scratch(e, u64{count - taken.number} * sizeof(Row)));
        u32 kept = 0;
        for (u32 i = front; i < count; i = taken.from(i + 1)) list.rows[kept++] = before[i];
        KERNEL_CHECK(e, kept == count - taken.number);
        list.count = kept;
        if (stored) list.capacity = kept;
        stored = false;
    }
    // Gives the fact at this position other arguments. Returns whether that keeps the order; otherwise it does nothing.
    [[gnu::always_inline]] bool change(Eval& e, u32 at, const Row& row) {
        if (at > 0 && T::key(list.rows[at - 1], row) > 0) return false;
        if (at + 1 < list.count && T::key(row, list.rows[at + 1]) > 0) return false;
        own(e);
        list.rows[at] = row;
        changed = true;
        return true;
    }
    [[gnu::always_inline]] void remove(Eval& e, u32 at) {
        KERNEL_CHECK(e, at < list.count && late == 0);
        changed = true;
        --list.count;
        if (at > 0) return remove_inside(e, at);
        ++list.rows;
        --list.capacity;
    }
    // The shorter side moves: facts are usually consumed from the front, and there may be a hundred thousand.
    MELD_STEP void remove_inside(Eval& e, u32 at) {
        const u32 before = list.count + 1;
        if (at < list.count && stored) {
            list.count = before;
            own(e);
            list.count = before - 1;
        }
        if (at < before / 2) {
            for (u32 i = at; i > 0; --i) list.rows[i] = list.rows[i - 1];
            ++list.rows;
            --list.capacity;
        } else {
            for (u32 i = at + 1; i < before; ++i) list.rows[i - 1] = list.rows[i];
            if (stored) --list.capacity;
        }
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

inline bool any_neighbour(const i32* neighbours, i32 ports) {
    for (i32 port = 0; port < ports; ++port)
        if (neighbours[port] >= 0) return true;
    return false;
}
// Sends it to all neighbours of the catom under evaluation, written once. Lattice: `neighbours` are those of a lattice (neighbours.h).
template <bool Lattice, class Row>
[[gnu::always_inline]] inline void send_to_neighbours(Eval& e, const i32* neighbours, i32 ports, u16 predicate, u16 column,
                                                      const Row& row) {
    Outgoing& out = e.outgoing[column];
    constexpr u64 size = sent_bytes(sizeof(Row));
    const u64 room = sizeof(u32) * static_cast<u64>(Lattice ? kNeighbourRoom : ports);
    if (static_cast<u64>(out.end - out.next) < size + room) [[unlikely]] {
        Letter letter;
        for (i32 port = 0; port < ports; ++port) {
            if (neighbours[port] < 0) continue;
            ++e.derivations;
            send_row(e, static_cast<u32>(neighbours[port]), predicate, column, row, letter);
        }
        return;
    }
    u8* const entry = out.next;
    u32 count = 0;
    // Most have all.
    if (Lattice && missing(neighbours) == 0) [[likely]] {
        __builtin_memcpy(entry + size, neighbours, sizeof(u32) * kNeighbourRoom);
        count = static_cast<u32>(ports);
    } else {
        for (i32 port = 0; port < ports; ++port) {
            __builtin_memcpy(entry + size + sizeof(u32) * count, &neighbours[port], sizeof(u32));
            count += neighbours[port] >= 0;
        }
    }
    if (count == 0) return;
    const SentRow head = {e.catom, count};
    __builtin_memcpy(entry, &head, sizeof head);
    __builtin_memcpy(entry + sizeof head, &row, sizeof row);
    out.next = entry + size + sizeof(u32) * count;
    out.sent += count;
    e.derivations += count;
}

// ColumnInfo::arrange.
template <class T, bool Short>
void arrange_rows(void* to, const void* before, u32 held_count, u32 count) {
    using Row = typename T::Row;
    Row* const rows = static_cast<Row*>(to);
    Row* const come = rows + held_count;
    sort_few<T, Short>(come, count);
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

// Whether rows stay in a block of this capacity (RowPool::fits).
inline bool fits_block(u32 count, u32 capacity, u64 row_bytes) {
    return count > 0 && count <= capacity && (count * 4 >= capacity || capacity * row_bytes <= 64);
}

// Writes what is left of linear facts without lists: in place, if it stays in its block.
template <class Row>
void store_rows(Eval& e, u16 column, const RowList<Row>& list) {
    RowsHead& head = reinterpret_cast<RowsHead*>(e.subdomain->columns[column])[e.catom];
    if (fits_block(list.count, head.capacity, sizeof(Row))) {
        Row* const rows = reinterpret_cast<Row*>(head.data);
        for (u32 i = 0; i < list.count; ++i) rows[i] = list.rows[i];
        head.count = list.count;
    } else if (list.count == 0 && head.capacity == 0) {
        // Most often nothing was there before: then the memory stays as it is.
        if (head.count != 0) head = {0, 0, nullptr};
    } else {
        e.host->assign_rows(&e, column, list.rows, list.count);
    }
}

// Persistent facts given by linear rules, messages or the world: a sorted set that only grows. Nobody proposes them, so the list of
// proposals is theirs: those that were given in this evaluation lie in it, with room on both sides, and the shorter part of them moves.
template <class T>
bool give_base(Eval& e, Relation<T>& r, const typename T::Row& row) {
    using Row = typename T::Row;
    const u32 at = lower_row<T>(r.rows, 0, r.count, row);
    if (at < r.count && T::key(r.rows[at], row) == 0) return false;
    ++e.derivations;
    RowList<Row>& list = r.proposed;
    Row* rows = const_cast<Row*>(r.rows);
    const bool own = list.capacity > 0, front = at < r.count / 2;
    const u32 before = own ? static_cast<u32>(rows - list.rows) : 0, behind = own ? list.capacity - before - r.count : 0;
    if ((front ? before : behind) == 0) {
        const u32 room = r.count / 2 + 4;
        list.capacity = r.count + 2 * room;
        list.rows = static_cast<Row*>(scratch(e, u64{list.capacity} * sizeof(Row)));
        Row* const to = list.rows + room;
        for (u32 i = 0; i < at; ++i) to[i] = rows[i];
        for (u32 i = at; i < r.count; ++i) to[i + 1] = rows[i];
        rows = to;
    } else if (front) {
        --rows;
        for (u32 i = 0; i < at; ++i) rows[i] = rows[i + 1];
    } else {
        for (u32 i = r.count; i > at; --i) rows[i] = rows[i - 1];
    }
    rows[at] = row;
    check_fact_limit(e, r.count + 1, r.rule);
    r.replace(rows, r.count + 1);
    return true;
}

}  // namespace meld
