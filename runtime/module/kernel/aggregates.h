// How each aggregate reduces the values of its matches, one class each, named after the table compiler/syntax/aggregates.def.
//
// An aggregate takes the values one by one with add(), counts them in `count`, and returns the reduction with result(). start() takes the
// first value of a group that has one, for aggregates that would otherwise have to begin with a zero; merge() takes the reduction of other
// values. The parameter V is the type of a value; ListRef for all of more than one word, or one of the tags below where an aggregate works
// on what is in them. No standard library.
#pragma once

#include "runtime/module/kernel/exact_mean.h"
#include "runtime/module/kernel/rows.h"

namespace meld {

struct Vector {};  // Three floats.
struct Text {};    // The bytes of a string.

template <class V>
struct CountOf {
    u64 count = 0;
    void add(Eval&, u32, V) { ++count; }
    i64 result(Eval&, u32) const { return static_cast<i64>(count); }
};

// For lists: sums of floats, element by element.
template <class V>
struct SumOf {
    u64 count = 0;
    V sum{};
    void start(V value) {
        sum = value;
        count = 1;
    }
    void add(Eval& e, u32 rule, V value) {
        if constexpr (__is_same(V, double))
            sum = checked_real(e, rule, sum + value);
        else
            sum = checked_add(e, rule, sum, value);
        ++count;
    }
    V result(Eval&, u32) const { return sum; }
};
// Element by element.
template <ListRef (*Add)(Eval&, u32, ListRef, ListRef)>
struct SumOfLists {
    u64 count = 0;
    ListRef sum = nullptr;
    void start(ListRef value) {
        sum = value;
        count = 1;
    }
    void add(Eval& e, u32 rule, ListRef value) { sum = count++ == 0 ? value : Add(e, rule, sum, value); }
    ListRef result(Eval&, u32) const { return sum; }
};
template <>
struct SumOf<ListRef> : SumOfLists<library::add_floats> {};
template <>
struct SumOf<Vector> : SumOfLists<library::vector_add> {
    // Of nothing: (0, 0, 0).
    ListRef result(Eval& e, u32) const { return count == 0 ? make_list(e, Words<3>{}) : sum; }
};

// The mean of floats, exact except for its one rounding: the sum and the count are stored together.
template <class V>
struct AvgOf {
    u64 count = 0;
    ExactMean mean{};
    void add(Eval& e, u32 rule, V value) {
        mean.add(checked_real(e, rule, value));
        ++count;
    }
    double result(Eval&, u32) const { return count == 0 ? 0 : mean.of(static_cast<u32>(count)); }
};

template <class V>
struct MinOf {
    u64 count = 0;
    V least{};
    void add(Eval&, u32, V value) {
        if (count++ == 0 || value < least) least = value;
    }
    V result(Eval&, u32) const { return least; }
};
template <class V>
struct MaxOf {
    u64 count = 0;
    V greatest{};
    void add(Eval&, u32, V value) {
        if (count++ == 0 || value > greatest) greatest = value;
    }
    V result(Eval&, u32) const { return greatest; }
};
// Values of more than one word are compared by content; of equal ones the first is kept.
template <>
struct MinOf<ListRef> {
    const TypeInfo* types;
    u16 type;
    u64 count = 0;
    ListRef least = nullptr;
    void add(Eval&, u32, ListRef value) {
        if (count++ == 0 || compare_lists(types, type, value, least) < 0) least = value;
    }
    ListRef result(Eval&, u32) const { return least; }
};
template <>
struct MaxOf<ListRef> {
    const TypeInfo* types;
    u16 type;
    u64 count = 0;
    ListRef greatest = nullptr;
    void add(Eval&, u32, ListRef value) {
        if (count++ == 0 || compare_lists(types, type, value, greatest) > 0) greatest = value;
    }
    ListRef result(Eval&, u32) const { return greatest; }
};

// Whether all values are true, and whether one is.
template <class V>
struct AndOf {
    u64 count = 0;
    bool all = true;
    void add(Eval&, u32, V value) {
        all = all && value;
        ++count;
    }
    bool result(Eval&, u32) const { return all; }
};
template <class V>
struct OrOf {
    u64 count = 0;
    bool any = false;
    void add(Eval&, u32, V value) {
        any = any || value;
        ++count;
    }
    bool result(Eval&, u32) const { return any; }
};

template <class V>
struct CollectOf {
    u64 count = 0;
    RowList<u64> items{};
    void add(Eval& e, u32, V value) {
        items.add(e, word(value));
        ++count;
    }
    ListRef result(Eval& e, u32) const { return list_over(e, items.rows, items.count); }
};

// The concatenation of lists or strings.
template <class V>
struct AppendOf {
    u64 count = 0;
    RowList<ListRef> lists{};
    void add(Eval& e, u32, ListRef list) {
        lists.add(e, list);
        ++count;
    }
    ListRef result(Eval& e, u32) const {
        return append_all(e, lists.count, [this](u32 i) { return lists.rows[i]; }, __is_same(V, Text) ? 1 : sizeof(u64));
    }
};
template <class V>
struct SetUnionOf {
    const TypeInfo* types;
    u16 type;  // The type of an element.
    AppendOf<V> sets{};
    void add(Eval& e, u32 rule, ListRef set) { sets.add(e, rule, set); }
    ListRef result(Eval& e, u32 rule) const { return list_to_set(e, rule, types, type, sets.result(e, rule)); }
};

// The `limit` least values in ascending order, or the greatest in descending order; all values if there are fewer.
template <class V>
struct MinKOf {
    const TypeInfo* types;
    u16 type;  // The type of an element.
    i64 limit;
    u64 count = 0;
    RowList<u64> items{};
    void add(Eval& e, u32, V value) {
        items.add(e, word(value));
        ++count;
    }
    // The best of all are among the best of each part.
    void merge(Eval& e, u32, ListRef list) {
        for (u32 i = 0; i < count_of(list); ++i) items.add(e, list->items[i]);
        ++count;
    }
    u32 size() const { return limit < 0 ? 0 : limit < i64{items.count} ? static_cast<u32>(limit) : items.count; }
    ListRef result(Eval& e, u32) const {
        sort_words(e, types, type, items.rows, items.count);
        return list_over(e, items.rows, size());
    }
};
template <class V>
struct MaxKOf : MinKOf<V> {
    ListRef result(Eval& e, u32) const {
        sort_words(e, this->types, this->type, this->items.rows, this->items.count);
        const u32 n = this->size();
        u64* descending = new_items(e, n);
        for (u32 i = 0; i < n; ++i) descending[i] = this->items.rows[this->items.count - 1 - i];
        return list_over(e, descending, n);
    }
};

// The reduction of one field over all candidates of a group; there is at least one.
template <class Row, class Aggregate, class Field>
auto combine_rows(Eval& e, u32 rule, Aggregate made, const Row* rows, u32 n, const Field& field) {
    u32 i = 0;
    if constexpr (requires { made.start(field(rows[0])); }) made.start(field(rows[i++]));
    for (; i < n; ++i) {
        if constexpr (requires { made.merge(e, rule, field(rows[0])); })
            made.merge(e, rule, field(rows[i]));
        else
            made.add(e, rule, field(rows[i]));
    }
    return made.result(e, rule);
}

}  // namespace meld
