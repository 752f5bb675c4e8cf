// Linear facts that catoms tell all their neighbours alike, read where they were written (module_abi.h, Broadcast). Each catom makes of
// them what would have been delivered: rows in order, together with those that it has.
#pragma once

#include "runtime/module/kernel/bags.h"

namespace meld {

// The facts of a predicate that a catom begins its evaluation with.
template <class T>
struct Heard {
    using Row = typename T::Row;
    const Row* rows;
    u32 count;
    bool come;  // Some are not in the column.
    Row said[kNeighbourRoom];
};

template <class T, bool Short>
[[gnu::noinline]] void add_held(Eval& e, Heard<T>& heard, const RowsHead& head) {
    using Row = typename T::Row;
    Row* const all = static_cast<Row*>(scratch(e, (u64{head.count} + heard.count) * sizeof(Row)));
    for (u32 i = 0; i < heard.count; ++i) all[head.count + i] = heard.said[i];
    arrange_rows<T, Short>(all, head.data, head.count, heard.count);
    heard.rows = all;
    heard.count += head.count;
}

// head: what the catom holds. heard: Broadcast::heard, or null if the catom was told nothing.
template <class T, bool Short>
[[gnu::always_inline]] inline void hear(Eval& e, Heard<T>& to, const RowsHead& head, const u8* heard, const i32* neighbours, i32 ports) {
    using Row = typename T::Row;
    constexpr i64 size = static_cast<i64>(broadcast_bytes(sizeof(Row)));
    to.rows = reinterpret_cast<const Row*>(head.data);
    to.count = head.count;
    to.come = false;
    if (heard == nullptr) return;
    const u64 last = e.subdomain->broadcast_round - 1;
    u32 count = 0;
    for (i32 port = 0; port < ports; ++port) {
        const u8* const entry = heard + i64{neighbours[port]} * size;
        u64 round;
        __builtin_memcpy(&round, entry, sizeof round);
        __builtin_memcpy(&to.said[count], entry + sizeof round, sizeof(Row));
        count += round == last;
    }
    if (count == 0) return;
    to.rows = to.said;
    to.count = count;
    to.come = true;
    if (head.count > 0) [[unlikely]]
        return add_held<T, Short>(e, to, head);
    sort_few<T, Short>(to.said, count);
}

// Asks the processor for what hear() will read.
template <class T>
inline void ask_for_heard(const u8* heard, const i32* neighbours, i32 ports) {
    if (heard == nullptr) return;
    for (i32 port = 0; port < ports; ++port)
        __builtin_prefetch(heard + i64{neighbours[port]} * static_cast<i64>(broadcast_bytes(sizeof(typename T::Row))));
}

// The same, while the neighbours are found.
template <class T>
inline void find_and_ask_for_heard(const Geometry& g, u32 site, i32* neighbours, i32 ports, const u8* heard) {
    for (i32 port = 0; port < ports; ++port) {
        const i32 there = catom_towards(g, site, port);
        neighbours[port] = there;
        __builtin_prefetch(heard + i64{there} * static_cast<i64>(broadcast_bytes(sizeof(typename T::Row))));
    }
}

// Whether all of these neighbours are on this process.
inline bool all_here(const Eval& e, const i32* neighbours, i32 ports) {
    const u8* const state = e.subdomain->geometry.catom_state;
    for (i32 port = 0; port < ports; ++port)
        if (neighbours[port] >= 0 && state[neighbours[port]] != kCatomOwned) return false;
    return true;
}

// By value, so that the row of whoever calls it need not be in memory.
template <class Row>
[[gnu::noinline]] void send_all_rows(Eval& e, const i32* neighbours, i32 ports, u16 predicate, u16 column, Row row) {
    send_to_neighbours<true>(e, neighbours, ports, predicate, column, row);
}

// As send_to_neighbours() on a lattice: says it once, for all to read, if the catom has not said anything yet.
template <class Row>
[[gnu::always_inline]] inline void tell_neighbours(Eval& e, const i32* neighbours, i32 ports, u16 predicate, u16 column, const Row& row) {
    const Broadcast& broadcast = e.subdomain->broadcasts[column];
    const u64 round = e.subdomain->broadcast_round;
    u8* const entry = broadcast.said + u64{e.catom} * broadcast_bytes(sizeof(Row));
    u64 said = round;
    if (broadcast.said != nullptr) __builtin_memcpy(&said, entry, sizeof said);
    if (said == round || !(e.subdomain->alone || all_here(e, neighbours, ports))) [[unlikely]]
        return send_all_rows<Row>(e, neighbours, ports, predicate, column, row);
    // Rules mostly have counted them already, and nothing has been written since.
    const u32 count = static_cast<u32>(count_neighbours(neighbours, ports));
    u8* const woken = broadcast.woken;
    for (i32 port = 0; port < ports; ++port) __atomic_store_n(&woken[neighbours[port]], u8{1}, __ATOMIC_RELAXED);
    __builtin_memcpy(entry, &round, sizeof round);
    __builtin_memcpy(entry + sizeof round, &row, sizeof row);
    e.outgoing[column].said += count;
    e.derivations += count;
}

}  // namespace meld
