// Values of the kernel's C++ types as words, and back.
#pragma once

#include <type_traits>

#include "runtime/module/kernel/library.h"

namespace meld::inspect {

inline Value make_value(i64 v) { return {.integer = v}; }
inline Value make_value(double v) { return {.real = v}; }
inline Value make_value(bool v) { return {.integer = v ? 1 : 0}; }
inline Value make_value(u64 v) { return {.catom = v}; }
inline Value make_value(ListRef v) { return {.list = v}; }

// The kernel has tags for types that stand for lists; their values are lists.
template <class T>
auto value_as(Value v) {
    if constexpr (std::is_same_v<T, bool>)
        return v.integer != 0;
    else if constexpr (std::is_same_v<T, double>)
        return v.real;
    else if constexpr (std::is_same_v<T, i64>)
        return v.integer;
    else if constexpr (std::is_same_v<T, u64>)
        return v.catom;
    else
        return v.list;
}

}  // namespace meld::inspect
