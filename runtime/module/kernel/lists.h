// Values of more than one word as emitted code makes, reads and compares them. All are made in scratch memory; the runtime copies those
// that a fact keeps. No standard library.
#pragma once

#include "runtime/module/kernel/values.h"

namespace meld {

// ---- words: one element or field, whatever its type

inline u64 word(i64 v) { return static_cast<u64>(v); }
inline u64 word(u64 v) { return v; }
inline u64 word(bool v) { return v; }
inline u64 word(double v) { return __builtin_bit_cast(u64, v); }
inline u64 word(ListRef v) { return __builtin_bit_cast(u64, v); }

template <class V>
V as(u64 w) {
    return __builtin_bit_cast(V, w);
}
template <>
inline bool as<bool>(u64 w) {
    return w != 0;
}

// ---- making and reading lists; null is the empty one

inline u32 count_of(ListRef l) { return l == nullptr ? 0 : l->count; }

// A list that a function walks along: its present position, and how much is left.
inline List contents(ListRef l) { return l == nullptr ? List{} : *l; }
inline void step(List& l) {
    if (l.count == 0) return;
    ++l.items;
    --l.count;
}

// A list over words that live as long as the evaluation. One that is too long is cut here, where all are made, before it grows further: the
// evaluation ends soon, but not at once.
inline ListRef list_over(Eval& e, const u64* items, u64 count, Trap kind = Trap::TooLong) {
    if (count == 0) return nullptr;
    if (count > e.subdomain->max_list) {
        trap(e, kind, e.rule, static_cast<i64>(count), static_cast<i64>(e.subdomain->max_list));
        return nullptr;
    }
    List* l = static_cast<List*>(scratch(e, sizeof(List)));
    *l = List{items, static_cast<u32>(count), 0};
    return l;
}
inline u64* new_items(Eval& e, u64 count) { return static_cast<u64*>(scratch(e, count * sizeof(u64))); }
inline char* new_text(Eval& e, u64 count) { return static_cast<char*>(scratch(e, count)); }

template <u32 N>
struct Words {
    u64 items[N];
};
template <u32 N>
ListRef make_list(Eval& e, const Words<N>& words) {
    u64* items = new_items(e, N);
    __builtin_memcpy(items, words.items, sizeof words.items);
    return list_over(e, items, N);
}
inline ListRef cons(Eval& e, u64 head, ListRef tail) {
    const u32 rest = count_of(tail);
    u64* items = new_items(e, u64{rest} + 1);
    items[0] = head;
    if (rest > 0) __builtin_memcpy(items + 1, tail->items, u64{rest} * sizeof(u64));
    return list_over(e, items, u64{rest} + 1);
}
inline ListRef append(Eval& e, ListRef a, ListRef b) {
    const u32 n = count_of(a), m = count_of(b);
    if (n == 0) return b;
    if (m == 0) return a;
    u64* items = new_items(e, u64{n} + m);
    __builtin_memcpy(items, a->items, u64{n} * sizeof(u64));
    __builtin_memcpy(items + n, b->items, u64{m} * sizeof(u64));
    return list_over(e, items, u64{n} + m);
}
// The concatenation of the lists list(0), ... list(n - 1), or of strings.
template <class ListOf>
ListRef append_all(Eval& e, u32 n, const ListOf& list, u32 item_bytes = sizeof(u64)) {
    u64 count = 0;
    for (u32 i = 0; i < n; ++i) count += count_of(list(i));
    const Trap kind = item_bytes == 1 ? Trap::TextTooLong : Trap::TooLong;
    if (count > e.subdomain->max_list) return list_over(e, nullptr, count, kind);
    u8* items = static_cast<u8*>(scratch(e, count * item_bytes));
    u8* at = items;
    for (u32 i = 0; i < n; ++i) {
        const ListRef l = list(i);
        if (l == nullptr) continue;
        __builtin_memcpy(at, l->items, u64{l->count} * item_bytes);
        at += u64{l->count} * item_bytes;
    }
    return list_over(e, reinterpret_cast<const u64*>(items), count, kind);
}
// Patterns read only after they have counted; an element that does not exist reads as zero.
inline u64 item(ListRef l, u32 i) { return i < count_of(l) ? l->items[i] : 0; }
inline ListRef tail(Eval& e, ListRef l) { return count_of(l) < 2 ? nullptr : list_over(e, l->items + 1, l->count - 1); }

// ---- strings: their items are bytes

inline const char* text_of(ListRef s) { return s == nullptr ? "" : reinterpret_cast<const char*>(s->items); }
inline ListRef text_over(Eval& e, const char* bytes, u64 count) {
    return list_over(e, reinterpret_cast<const u64*>(bytes), count, Trap::TextTooLong);
}
inline ListRef make_text(Eval& e, const char* bytes, u64 count) {
    if (count == 0) return nullptr;
    char* copy = new_text(e, count);
    __builtin_memcpy(copy, bytes, count);
    return text_over(e, copy, count);
}
inline ListRef join_text(Eval& e, ListRef a, ListRef b) {
    const u32 n = count_of(a), m = count_of(b);
    if (n == 0) return b;
    if (m == 0) return a;
    char* copy = new_text(e, u64{n} + m);
    __builtin_memcpy(copy, a->items, n);
    __builtin_memcpy(copy + n, b->items, m);
    return text_over(e, copy, u64{n} + m);
}

// ---- order: three-way, by content. A prefix comes before the longer value.

inline int compare_lists(const TypeInfo* types, u16 type, ListRef a, ListRef b);

inline int compare_words(const TypeInfo* types, u16 type, u64 a, u64 b) {
    switch (types[type].kind) {
        case ValueType::Int:
            return compare(as<i64>(a), as<i64>(b));
        case ValueType::Float:
            return compare(as<double>(a), as<double>(b));
        case ValueType::Bool:
        case ValueType::Node:
            return compare(a, b);
        default:
            return compare_lists(types, type, as<ListRef>(a), as<ListRef>(b));
    }
}
inline int compare_lists(const TypeInfo* types, u16 type, ListRef a, ListRef b) {
    if (a == b) return 0;
    const u32 n = count_of(a), m = count_of(b), both = n < m ? n : m;
    const TypeInfo& t = types[type];
    if (t.kind == ValueType::String) {
        if (const int c = both == 0 ? 0 : __builtin_memcmp(a->items, b->items, both)) return c;
        return compare(n, m);
    }
    const bool record = t.kind == ValueType::Struct || t.kind == ValueType::Tuple;
    for (u32 i = 0; i < both; ++i) {
        if (t.kind == ValueType::Vec3) {
            if (const int c = compare(as<double>(a->items[i]), as<double>(b->items[i]))) return c;
        } else if (const int c = compare_words(types, t.parts[record ? i : 0], a->items[i], b->items[i])) {
            return c;
        }
    }
    return compare(n, m);
}

// ---- hash: by content, so that values that are equal have one: -0 and 0, too

inline u64 hash_list(const TypeInfo* types, u16 type, ListRef l) {
    const TypeInfo& t = types[type];
    u64 h = mix(static_cast<u64>(t.kind), count_of(l));
    const bool record = t.kind == ValueType::Struct || t.kind == ValueType::Tuple;
    for (u32 i = 0; i < count_of(l); ++i) {
        if (t.kind == ValueType::String) {
            h = mix(h, static_cast<unsigned char>(text_of(l)[i]));
            continue;
        }
        const u16 part = t.kind == ValueType::Vec3 ? 1 : t.parts[record ? i : 0];
        h = mix(h, types[part].kind == ValueType::Float   ? bits_of(as<double>(l->items[i]) + 0.0)
                   : types[part].kind < ValueType::String ? l->items[i]
                                                          : hash_list(types, part, as<ListRef>(l->items[i])));
    }
    return h;
}

// ---- sorting and sets

// Sorts words of this type in place: a stable merge sort by runs of doubling length.
[[gnu::noinline]] inline void sort_words(Eval& e, const TypeInfo* types, u16 type, u64* words, u32 count) {
    u64* from = words;
    u64* to = new_items(e, count);
    for (u64 width = 1; width < count; width *= 2) {
        for (u64 low = 0; low < count; low += 2 * width) {
            const u64 middle = low + width < count ? low + width : count;
            const u64 high = low + 2 * width < count ? low + 2 * width : count;
            u64 a = low, b = middle;
            for (u64 k = low; k < high; ++k) {
                const bool left = a < middle && (b >= high || compare_words(types, type, from[a], from[b]) <= 0);
                to[k] = from[left ? a++ : b++];
            }
        }
        u64* swap = from;
        from = to;
        to = swap;
    }
    if (from != words) __builtin_memcpy(words, from, u64{count} * sizeof(u64));
}
// The elements of a list in order, without duplicates.
inline ListRef list_to_set(Eval& e, u32, const TypeInfo* types, u16 type, ListRef l) {
    const u32 n = count_of(l);
    u32 kept = 0;
    for (u32 i = 1; i < n && compare_words(types, type, l->items[i - 1], l->items[i]) < 0; ++i) ++kept;
    if (n < 2 || kept == n - 1) return l;
    u64* items = new_items(e, n);
    __builtin_memcpy(items, l->items, u64{n} * sizeof(u64));
    sort_words(e, types, type, items, n);
    kept = 0;
    for (u32 i = 0; i < n; ++i)
        if (kept == 0 || compare_words(types, type, items[kept - 1], items[i]) != 0) items[kept++] = items[i];
    return list_over(e, items, kept);
}

// ---- checks of the results of extern functions: no NaN, sets sorted, structs with all their fields

inline ListRef checked_extern(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef l);

inline i64 checked_extern(Eval&, u32, const TypeInfo*, u16, i64 v) { return v; }
inline u64 checked_extern(Eval&, u32, const TypeInfo*, u16, u64 v) { return v; }
inline bool checked_extern(Eval&, u32, const TypeInfo*, u16, bool v) { return v; }
inline double checked_extern(Eval& e, u32 rule, const TypeInfo*, u16, double v) { return checked_real(e, rule, v); }

inline u64 checked_item(Eval& e, u32 rule, const TypeInfo* types, u16 type, u64 w) {
    if (types[type].kind == ValueType::Float) return word(checked_real(e, rule, as<double>(w)));
    return types[type].kind < ValueType::String ? w : word(checked_extern(e, rule, types, type, as<ListRef>(w)));
}
inline ListRef checked_extern(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef l) {
    const TypeInfo& t = types[type];
    if (t.kind == ValueType::String) return l == nullptr ? nullptr : text_over(e, text_of(l), l->count);
    const bool record = t.kind >= ValueType::Struct;
    const u32 n = count_of(l), fields = t.kind == ValueType::Vec3 ? 3 : t.part_count;
    if (record && n != fields) {
        trap(e, Trap::BadIndex, rule, i64{fields} - 1, i64{n});
        return nullptr;
    }
    u64* items = new_items(e, n);
    for (u32 i = 0; i < n; ++i)
        items[i] = checked_item(e, rule, types, t.kind == ValueType::Vec3 ? 1 : t.parts[record ? i : 0], l->items[i]);
    const ListRef checked = list_over(e, items, n);
    return t.kind == ValueType::Set ? list_to_set(e, rule, types, t.parts[0], checked) : checked;
}

}  // namespace meld
