// The linear facts of a catom that holds at most one of each predicate, and the messages that its rules take in one pass: small enough for
// registers. What does not fit is left to bags (bags.h).
#pragma once

#include "runtime/module/kernel/bags.h"

namespace meld {

template <class T>
struct Single {
    typename T::Row row;
    bool holds, changed;

    // Returns whether there is at most one.
    [[gnu::always_inline]] bool open(const RowsHead& head) {
        holds = head.count != 0;
        changed = false;
        if (holds) row = *reinterpret_cast<const typename T::Row*>(head.data);
        return head.count <= 1;
    }
    [[gnu::always_inline]] void take() {
        holds = false;
        changed = true;
    }
    [[gnu::always_inline]] void become(const typename T::Row& fact) {
        row = fact;
        holds = changed = true;
    }
    [[gnu::always_inline]] void put(Eval& e, const typename T::Row& fact) {
        ++e.derivations;
        become(fact);
    }
    [[gnu::always_inline]] void give_to(Eval& e, Bag<T>& bag) const {
        bag.list.count = bag.list.capacity = bag.late = 0;
        bag.changed = true;
        if (!holds) return;
        const typename T::Row fact = row;  // Elsewhere in memory, so that this one need not be there.
        bag.become(e, fact);
    }
    // Writes what has changed to the column.
    template <bool Lists>
    [[gnu::always_inline]] void store(Eval& e, u16 column) const {
        if (!changed) return;
        RowsHead& head = reinterpret_cast<RowsHead*>(e.subdomain->columns[column])[e.catom];
        if (!Lists && holds && fits_block(1, head.capacity, sizeof row)) {
            *reinterpret_cast<typename T::Row*>(head.data) = row;
            head.count = 1;
        } else if (!Lists && !holds && head.capacity == 0) {
            if (head.count != 0) head = {0, 0, nullptr};
        } else {
            const typename T::Row fact = row;
            e.host->assign_rows(&e, column, &fact, holds);
        }
    }
};

// Read where they lie, and taken from the first on.
template <class T>
struct Messages {
    const typename T::Row* rows;
    u32 count;
    bool changed;

    [[gnu::always_inline]] bool open(const RowsHead& head) {
        open(reinterpret_cast<const typename T::Row*>(head.data), head.count, false);
        return true;
    }
    // elsewhere: not all of them are in the column.
    [[gnu::always_inline]] void open(const typename T::Row* from, u32 n, bool elsewhere) {
        rows = from;
        count = n;
        changed = elsewhere;
    }
    [[gnu::always_inline]] void take(u32 first) {
        rows += first;
        count -= first;
        changed = true;
    }
    [[gnu::always_inline]] void give_to(Eval&, Bag<T>& bag) const {
        bag.list.rows = const_cast<typename T::Row*>(rows);
        bag.list.count = bag.list.capacity = count;
        bag.changed = true;
    }
    template <bool Lists>
    [[gnu::always_inline]] void store(Eval& e, u16 column) const {
        if (!changed) return;
        RowsHead& head = reinterpret_cast<RowsHead*>(e.subdomain->columns[column])[e.catom];
        if (Lists || count != 0 || head.capacity != 0)
            e.host->assign_rows(&e, column, rows, count);
        else if (head.count != 0)
            head = {0, 0, nullptr};
    }
};

}  // namespace meld
