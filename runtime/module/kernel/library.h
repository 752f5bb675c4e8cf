// The functions of the library (compiler/check/program/library.def describes their results). Each takes the evaluation and the rule that a
// trap names; those that compare also take the type of the elements. No standard library except libm and two functions of libc.
#pragma once

#include "runtime/module/kernel/lists.h"

extern "C" {
int snprintf(char* text, unsigned long size, const char* format, ...) noexcept;
double strtod(const char* text, char** end) noexcept;
}

namespace meld::library {

// ---- lists and arrays

inline i64 length(Eval&, u32, ListRef l) { return count_of(l); }

inline u64 nth(Eval& e, u32 rule, ListRef l, i64 i) {
    if (i >= 0 && i < i64{count_of(l)}) return l->items[i];
    trap(e, Trap::BadIndex, rule, i, i64{count_of(l)});
    return 0;
}
inline u64 first(Eval& e, u32 rule, ListRef l) { return nth(e, rule, l, 0); }
inline u64 last(Eval& e, u32 rule, ListRef l) { return nth(e, rule, l, i64{count_of(l)} - 1); }

inline ListRef part(Eval& e, ListRef l, i64 from, i64 to) {
    const i64 n = count_of(l);
    from = from < 0 ? 0 : from;
    to = to > n ? n : to;
    if (from >= to) return nullptr;
    return from == 0 && to == n ? l : list_over(e, l->items + from, static_cast<u64>(to - from));
}
inline ListRef tail(Eval& e, u32, ListRef l) { return part(e, l, 1, count_of(l)); }
inline ListRef take(Eval& e, u32, ListRef l, i64 n) { return part(e, l, 0, n); }
inline ListRef drop(Eval& e, u32, ListRef l, i64 n) { return part(e, l, n, count_of(l)); }
inline ListRef sublist(Eval& e, u32, ListRef l, i64 from, i64 to) { return part(e, l, from, to); }
inline ListRef append(Eval& e, u32, ListRef a, ListRef b) { return meld::append(e, a, b); }
inline ListRef add_last(Eval& e, u32, ListRef l, u64 x) { return meld::append(e, l, make_list(e, Words<1>{{x}})); }
inline ListRef reverse(Eval& e, u32, ListRef l) {
    const u32 n = count_of(l);
    if (n < 2) return l;
    u64* items = new_items(e, n);
    for (u32 i = 0; i < n; ++i) items[i] = l->items[n - 1 - i];
    return list_over(e, items, n);
}
inline ListRef replace(Eval& e, u32 rule, ListRef l, i64 i, u64 x) {
    nth(e, rule, l, i);
    if (e.trap != Trap::None) return l;
    u64* items = new_items(e, l->count);
    __builtin_memcpy(items, l->items, u64{l->count} * sizeof(u64));
    items[i] = x;
    return list_over(e, items, l->count);
}
inline ListRef same(Eval&, u32, ListRef l) { return l; }
inline ListRef repeated(Eval& e, u32, i64 n, u64 x) {
    if (n <= 0) return nullptr;
    if (static_cast<u64>(n) > e.subdomain->max_list) return list_over(e, nullptr, static_cast<u64>(n));
    u64* items = new_items(e, static_cast<u64>(n));
    for (i64 i = 0; i < n; ++i) items[i] = x;
    return list_over(e, items, static_cast<u64>(n));
}

inline i64 index_of(Eval&, u32, const TypeInfo* types, u16 type, ListRef l, u64 x) {
    for (u32 i = 0; i < count_of(l); ++i)
        if (compare_words(types, type, l->items[i], x) == 0) return i;
    return -1;
}
inline bool exists(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef l, u64 x) {
    return index_of(e, rule, types, type, l, x) >= 0;
}
inline i64 count(Eval&, u32, const TypeInfo* types, u16 type, ListRef l, u64 x) {
    i64 n = 0;
    for (u32 i = 0; i < count_of(l); ++i) n += compare_words(types, type, l->items[i], x) == 0;
    return n;
}
template <class Keep>
ListRef filter(Eval& e, ListRef l, const Keep& keep) {
    u32 kept = 0;
    u64* items = new_items(e, count_of(l));
    for (u32 i = 0; i < count_of(l); ++i)
        if (keep(i)) items[kept++] = l->items[i];
    return list_over(e, items, kept);
}
inline ListRef remove(Eval& e, u32, const TypeInfo* types, u16 type, ListRef l, u64 x) {
    return filter(e, l, [&](u32 i) { return compare_words(types, type, l->items[i], x) != 0; });
}
inline ListRef sort(Eval& e, u32, const TypeInfo* types, u16 type, ListRef l) {
    if (count_of(l) < 2) return l;
    u64* items = new_items(e, l->count);
    __builtin_memcpy(items, l->items, u64{l->count} * sizeof(u64));
    sort_words(e, types, type, items, l->count);
    return list_over(e, items, l->count);
}
// The index of an element in a sorted list, or where it would be inserted.
inline u32 place_in(const TypeInfo* types, u16 type, ListRef sorted, u64 x) {
    u32 low = 0, high = count_of(sorted);
    while (low < high) {
        const u32 middle = low + (high - low) / 2;
        if (compare_words(types, type, sorted->items[middle], x) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}
inline bool member(Eval&, u32, const TypeInfo* types, u16 type, ListRef set, u64 x) {
    const u32 at = place_in(types, type, set, x);
    return at < count_of(set) && compare_words(types, type, set->items[at], x) == 0;
}
// The elements of one list that are, or are not, in the other, in their order.
inline ListRef common(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef l, ListRef other) {
    const ListRef set = list_to_set(e, rule, types, type, other);
    return filter(e, l, [&](u32 i) { return member(e, rule, types, type, set, l->items[i]); });
}
inline ListRef difference(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef l, ListRef other) {
    const ListRef set = list_to_set(e, rule, types, type, other);
    return filter(e, l, [&](u32 i) { return !member(e, rule, types, type, set, l->items[i]); });
}
inline bool subset(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef l, ListRef of) {
    return count_of(difference(e, rule, types, type, l, of)) == 0;
}
// Whether they have an element in common.
inline bool meets(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef l, ListRef other) {
    for (u32 i = 0; i < count_of(other); ++i)
        if (exists(e, rule, types, type, l, other->items[i])) return true;
    return false;
}
inline ListRef list_union(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef a, ListRef b) {
    return meld::append(e, a, difference(e, rule, types, type, b, a));
}
// Each element at its first occurrence.
inline ListRef unique(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef l) {
    return filter(e, l, [&](u32 i) { return !exists(e, rule, types, type, part(e, l, 0, i), l->items[i]); });
}
inline bool equal(Eval&, u32, const TypeInfo* types, u16 type, ListRef a, ListRef b) {
    if (count_of(a) != count_of(b)) return false;
    for (u32 i = 0; i < count_of(a); ++i)
        if (compare_words(types, type, a->items[i], b->items[i]) != 0) return false;
    return true;
}
inline u64 least(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef l) {
    u64 best = first(e, rule, l);
    for (u32 i = 1; i < count_of(l); ++i)
        if (compare_words(types, type, l->items[i], best) < 0) best = l->items[i];
    return best;
}
inline u64 greatest(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef l) {
    u64 best = first(e, rule, l);
    for (u32 i = 1; i < count_of(l); ++i)
        if (compare_words(types, type, l->items[i], best) > 0) best = l->items[i];
    return best;
}
inline i64 plus(Eval& e, u32 rule, i64 a, i64 b) { return checked_add(e, rule, a, b); }
inline double plus(Eval& e, u32 rule, double a, double b) { return checked_real(e, rule, a + b); }
template <class V>
V sum(Eval& e, u32 rule, ListRef l) {
    V total = 0;
    for (u32 i = 0; i < count_of(l); ++i) total = plus(e, rule, total, as<V>(l->items[i]));
    return total;
}

// ---- sets: sorted, each element once

inline ListRef to_set(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef l) { return list_to_set(e, rule, types, type, l); }
inline ListRef set_union(Eval& e, u32 rule, const TypeInfo* types, u16 type, ListRef a, ListRef b) {
    return list_to_set(e, rule, types, type, meld::append(e, a, b));
}
inline ListRef set_add(Eval& e, u32, const TypeInfo* types, u16 type, ListRef set, u64 x) {
    const u32 n = count_of(set), at = place_in(types, type, set, x);
    if (at < n && compare_words(types, type, set->items[at], x) == 0) return set;
    u64* items = new_items(e, u64{n} + 1);
    if (at > 0) __builtin_memcpy(items, set->items, u64{at} * sizeof(u64));
    items[at] = x;
    if (at < n) __builtin_memcpy(items + at + 1, set->items + at, u64{n - at} * sizeof(u64));
    return list_over(e, items, u64{n} + 1);
}

// ---- numbers

inline i64 power(Eval& e, u32 rule, i64 a, i64 b) { return checked_power(e, rule, a, b); }
inline i64 floor(Eval& e, u32 rule, double a) { return checked_truncate(e, rule, __builtin_floor(a)); }
inline i64 ceil(Eval& e, u32 rule, double a) { return checked_truncate(e, rule, __builtin_ceil(a)); }
inline i64 round(Eval& e, u32 rule, double a) { return checked_truncate(e, rule, __builtin_round(a)); }
inline double truncate_to(Eval& e, u32 rule, double a, i64 digits) {
    const double scale = __builtin_pow(10, static_cast<double>(digits));
    return checked_real(e, rule, __builtin_trunc(a * scale) / scale);
}
#define MELD_REAL_FUNCTION(name) \
    inline double name(Eval& e, u32 rule, double a) { return checked_real(e, rule, __builtin_##name(a)); }
MELD_REAL_FUNCTION(sin)
MELD_REAL_FUNCTION(cos)
MELD_REAL_FUNCTION(tan)
MELD_REAL_FUNCTION(asin)
MELD_REAL_FUNCTION(acos)
MELD_REAL_FUNCTION(atan)
MELD_REAL_FUNCTION(exp)
MELD_REAL_FUNCTION(log)
#undef MELD_REAL_FUNCTION
inline double atan2(Eval& e, u32 rule, double y, double x) { return checked_real(e, rule, __builtin_atan2(y, x)); }
inline double pow(Eval& e, u32 rule, double a, double b) { return checked_real(e, rule, __builtin_pow(a, b)); }
inline double sigmoid(Eval& e, u32 rule, double a) { return checked_real(e, rule, 1 / (1 + __builtin_exp(-a))); }

// ---- random numbers

inline i64 random_below(Eval& e, u32 rule, i64 n) {
    if (n <= 0) trap(e, Trap::NothingBelow, rule, n);
    // The high half of a product is below n, and all values are equally likely, up to a few in 2^64.
    __extension__ using Wide = unsigned __int128;
    return n <= 0 ? 0 : static_cast<i64>(static_cast<u64>((static_cast<Wide>(e.host->random(&e)) * static_cast<u64>(n)) >> 64));
}
inline double random_real(Eval& e, u32) { return static_cast<double>(e.host->random(&e) >> 11) * 0x1p-53; }

// ---- strings: UTF-8; a character is a byte that does not continue another one

inline bool continues(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }
inline i64 characters(Eval&, u32, ListRef s) {
    i64 n = 0;
    for (u32 i = 0; i < count_of(s); ++i) n += !continues(text_of(s)[i]);
    return n;
}
// The start of the character with this number.
inline u32 byte_of(ListRef s, i64 character) {
    u32 i = 0;
    for (; i < count_of(s); ++i)
        if (!continues(text_of(s)[i]) && character-- <= 0) break;
    return i;
}
inline ListRef substring(Eval& e, u32, ListRef s, i64 from, i64 n) {
    if (from < 0) n = n + from < n ? n + from : 0;
    const i64 first_one = from < 0 ? 0 : from;
    if (n <= 0) return nullptr;
    const u32 begin = byte_of(s, first_one), all = count_of(s);
    const u32 end = n > all ? all : byte_of(s, first_one + n);
    return begin >= end ? nullptr : text_over(e, text_of(s) + begin, end - begin);
}
inline ListRef join(Eval& e, u32, ListRef a, ListRef b) { return join_text(e, a, b); }
inline ListRef letters(Eval& e, u32 rule, ListRef s) {
    const i64 n = characters(e, rule, s);
    u64* items = new_items(e, static_cast<u64>(n));
    u32 at = 0;
    for (i64 i = 0; i < n; ++i) {
        const u32 begin = at++;
        while (at < count_of(s) && continues(text_of(s)[at])) ++at;
        items[i] = word(text_over(e, text_of(s) + begin, at - begin));
    }
    return list_over(e, items, static_cast<u64>(n));
}
inline ListRef from_unsigned(Eval& e, u64 v, char sign) {
    char digits[24];
    u32 at = sizeof digits;
    do digits[--at] = static_cast<char>('0' + v % 10);
    while ((v /= 10) != 0);
    if (sign != 0) digits[--at] = sign;
    return make_text(e, digits + at, sizeof digits - at);
}
inline ListRef from_int(Eval& e, u32, i64 v) {
    return v < 0 ? from_unsigned(e, 0 - static_cast<u64>(v), '-') : from_unsigned(e, static_cast<u64>(v), 0);
}
inline ListRef from_node(Eval& e, u32, u64 v) { return from_unsigned(e, v, '@'); }
// The fewest digits that read back as the same number, with a point or an exponent as Meld writes floats.
inline ListRef from_real(Eval& e, u32, double v) {
    char text[40];
    int n = 0;
    for (int digits = 1; digits <= 17; ++digits) {
        n = snprintf(text, sizeof text, "%.*g", digits, v);
        if (strtod(text, nullptr) == v) break;
    }
    bool whole = true;
    for (int i = 0; i < n; ++i) whole = whole && ((text[i] >= '0' && text[i] <= '9') || text[i] == '-');
    if (whole) {
        text[n++] = '.';
        text[n++] = '0';
    }
    return make_text(e, text, static_cast<u64>(n));
}
inline i64 to_int(Eval& e, u32 rule, ListRef s) {
    const u32 n = count_of(s);
    const char* text = text_of(s);
    const bool minus = n > 0 && text[0] == '-';
    i64 value = 0;
    bool wrong = n == (minus ? 1u : 0u);
    for (u32 i = minus; i < n; ++i) {
        const int digit = text[i] - '0';
        wrong =
            wrong || digit < 0 || digit > 9 || __builtin_mul_overflow(value, 10, &value) || __builtin_sub_overflow(value, digit, &value);
    }
    // Counted downwards, so that the least int can be read too.
    if (!minus) wrong = __builtin_sub_overflow(i64{0}, value, &value) || wrong;
    if (wrong) trap_text(e, Trap::NotAnInt, rule, text, n);
    return wrong ? 0 : value;
}
inline ListRef to_ints(Eval& e, u32 rule, ListRef s) {
    const char* text = text_of(s);
    const u32 n = count_of(s);
    const auto between = [](char c) { return c == ',' || c == ' '; };
    u64* items = new_items(e, u64{n} / 2 + 1);
    u64 count = 0;
    for (u32 from = 0; from < n;) {
        u32 to = from;
        while (to < n && !between(text[to])) ++to;
        if (to > from) items[count++] = word(to_int(e, rule, make_text(e, text + from, to - from)));
        from = to + 1;
    }
    return list_over(e, items, count);
}
inline double to_real(Eval& e, u32 rule, ListRef s) {
    char text[64] = {};
    const u32 n = count_of(s);
    char* end = text;
    if (n > 0 && n < sizeof text) __builtin_memcpy(text, s->items, n);
    const bool starts = (text[0] >= '0' && text[0] <= '9') || text[0] == '-' || text[0] == '.';
    const double value = starts ? strtod(text, &end) : 0;
    if (!starts || end != text + n) trap_text(e, Trap::NotAFloat, rule, text_of(s), n);
    return checked_real(e, rule, value);
}

// ---- lists of floats in belief propagation: logarithms of likelihoods

template <class F>
ListRef pairwise(Eval& e, u32 rule, ListRef a, ListRef b, const F& f) {
    const u32 n = count_of(a) < count_of(b) ? count_of(a) : count_of(b);
    u64* items = new_items(e, n);
    for (u32 i = 0; i < n; ++i) items[i] = word(checked_real(e, rule, f(as<double>(a->items[i]), as<double>(b->items[i]))));
    return list_over(e, items, n);
}
inline ListRef add_floats(Eval& e, u32 rule, ListRef a, ListRef b) {
    return pairwise(e, rule, a, b, [](double x, double y) { return x + y; });
}
inline ListRef divide(Eval& e, u32 rule, ListRef a, ListRef b) {
    return pairwise(e, rule, a, b, [](double x, double y) { return x - y; });
}
inline ListRef damp(Eval& e, u32 rule, ListRef a, ListRef b, double factor) {
    return pairwise(e, rule, a, b,
                    [factor](double x, double y) { return __builtin_log(factor * __builtin_exp(y) + (1 - factor) * __builtin_exp(x)); });
}
// So that the likelihoods sum to 1.
inline ListRef normalize(Eval& e, u32 rule, ListRef l) {
    if (count_of(l) == 0) return l;
    double most = as<double>(l->items[0]), all = 0;
    for (u32 i = 1; i < l->count; ++i) most = greatest_of(most, as<double>(l->items[i]));
    for (u32 i = 0; i < l->count; ++i) all += __builtin_exp(as<double>(l->items[i]) - most);
    const double shift = most + __builtin_log(all);
    return pairwise(e, rule, l, l, [shift](double x, double) { return x - shift; });
}
// The message of a neighbour with these beliefs over a link with this potential: an n by n table, column by column.
inline ListRef convolve(Eval& e, u32 rule, ListRef table, ListRef l) {
    const u32 n = count_of(l);
    u64* items = new_items(e, n);
    for (u32 x = 0; x < n; ++x) {
        double all = 0;
        for (u32 y = 0; y < n; ++y) {
            const u32 at = x + y * n;
            all += __builtin_exp((at < count_of(table) ? as<double>(table->items[at]) : 0) + as<double>(l->items[y]));
        }
        // The logarithm of zero would break all later arithmetic; the least positive number serves as well.
        items[x] = word(checked_real(e, rule, __builtin_log(all == 0 ? __DBL_MIN__ : all)));
    }
    return list_over(e, items, n);
}
inline double residual(Eval& e, u32 rule, ListRef a, ListRef b) {
    const u32 n = count_of(a) < count_of(b) ? count_of(a) : count_of(b);
    double all = 0;
    for (u32 i = 0; i < n; ++i) all += __builtin_fabs(__builtin_exp(as<double>(a->items[i])) - __builtin_exp(as<double>(b->items[i])));
    return checked_real(e, rule, n == 0 ? 0 : all / n);
}

// ---- vectors

inline double coordinate(ListRef v, u32 i) { return as<double>(item(v, i)); }
inline double x(Eval&, u32, ListRef v) { return coordinate(v, 0); }
inline double y(Eval&, u32, ListRef v) { return coordinate(v, 1); }
inline double z(Eval&, u32, ListRef v) { return coordinate(v, 2); }
inline ListRef make_vector(Eval& e, u32 rule, double x, double y, double z) {
    return make_list(e, Words<3>{{word(checked_real(e, rule, x)), word(checked_real(e, rule, y)), word(checked_real(e, rule, z))}});
}
inline double dot(Eval& e, u32 rule, ListRef a, ListRef b) {
    return checked_real(e, rule,
                        coordinate(a, 0) * coordinate(b, 0) + coordinate(a, 1) * coordinate(b, 1) + coordinate(a, 2) * coordinate(b, 2));
}
inline double norm(Eval& e, u32 rule, ListRef a) { return __builtin_sqrt(dot(e, rule, a, a)); }
inline ListRef cross(Eval& e, u32 rule, ListRef a, ListRef b) {
    const double ax = coordinate(a, 0), ay = coordinate(a, 1), az = coordinate(a, 2), bx = coordinate(b, 0), by = coordinate(b, 1),
                 bz = coordinate(b, 2);
    return make_vector(e, rule, ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx);
}
inline ListRef vector_add(Eval& e, u32 rule, ListRef a, ListRef b) {
    return make_vector(e, rule, coordinate(a, 0) + coordinate(b, 0), coordinate(a, 1) + coordinate(b, 1),
                       coordinate(a, 2) + coordinate(b, 2));
}
inline ListRef vector_scale(Eval& e, u32 rule, ListRef a, double f) {
    return make_vector(e, rule, coordinate(a, 0) * f, coordinate(a, 1) * f, coordinate(a, 2) * f);
}
inline ListRef vector_subtract(Eval& e, u32 rule, ListRef a, ListRef b) { return vector_add(e, rule, a, vector_scale(e, rule, b, -1)); }
inline ListRef vector_divide(Eval& e, u32 rule, ListRef a, double f) {
    if (f == 0) trap(e, Trap::DivisionByZero, rule, coordinate(a, 0), f);
    return f == 0 ? a : make_vector(e, rule, coordinate(a, 0) / f, coordinate(a, 1) / f, coordinate(a, 2) / f);
}
inline u64 row_of(Eval& e, u32 rule, const double* v) { return word(make_vector(e, rule, v[0], v[1], v[2])); }
inline ListRef nearest_rotation(Eval& e, u32 rule, ListRef a, ListRef b, ListRef c) {
    const ListRef rows[3] = {a, b, c};
    double matrix[9], r[9];
    for (u32 i = 0; i < 9; ++i) matrix[i] = coordinate(rows[i / 3], i % 3);
    e.host->nearest_rotation(matrix, r);
    return make_list(e, Words<3>{{row_of(e, rule, r), row_of(e, rule, r + 3), row_of(e, rule, r + 6)}});
}
// W. Kabsch, "A solution for the best rotation to relate two sets of vectors", Acta Crystallographica A32, 1976: the rotation nearest to
// the sum of the outer products of the points, seen from their centroids.
inline ListRef align(Eval& e, u32 rule, ListRef from, ListRef to) {
    const u32 n = count_of(from), paired = n < count_of(to) ? n : count_of(to);
    if (n == 0 || count_of(to) != n) {
        trap(e, Trap::BadIndex, rule, i64{paired}, i64{paired});
        return nullptr;
    }
    double middle_from[3] = {}, middle_to[3] = {}, matrix[9] = {};
    for (u32 k = 0; k < 3; ++k) {
        for (u32 i = 0; i < n; ++i) {
            middle_from[k] += coordinate(as<ListRef>(from->items[i]), k) / n;
            middle_to[k] += coordinate(as<ListRef>(to->items[i]), k) / n;
        }
    }
    for (u32 i = 0; i < n; ++i)
        for (u32 k = 0; k < 3; ++k)
            for (u32 m = 0; m < 3; ++m)
                matrix[3 * k + m] += (coordinate(as<ListRef>(to->items[i]), k) - middle_to[k]) *
                                     (coordinate(as<ListRef>(from->items[i]), m) - middle_from[m]);
    double r[9], shift[3];
    e.host->nearest_rotation(matrix, r);
    for (u32 k = 0; k < 3; ++k)
        shift[k] = middle_to[k] - (r[3 * k] * middle_from[0] + r[3 * k + 1] * middle_from[1] + r[3 * k + 2] * middle_from[2]);
    return make_list(e, Words<4>{{row_of(e, rule, r), row_of(e, rule, r + 3), row_of(e, rule, r + 6), row_of(e, rule, shift)}});
}
inline double distance(Eval& e, u32 rule, ListRef a, ListRef b) { return norm(e, rule, vector_subtract(e, rule, a, b)); }

}  // namespace meld::library
