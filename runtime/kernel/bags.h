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
        for (u32 i = 0; i < n; ++i) list.add(e, from[i]);
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
