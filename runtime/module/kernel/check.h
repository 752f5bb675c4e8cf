// What the kernel takes for granted. A module that is compiled with `meldc compile --checked`, as those are that tests compare with the
// reference, ends the run where it does not hold; other modules do not contain the conditions.
#pragma once

#include "runtime/module/abi/module_abi.h"

// A condition that a function of the kernel expects, holds or ensures. After a failure of the program (Eval::trap) the evaluation is
// abandoned, and nothing is promised any more.
#ifdef MELD_CHECKED
#define KERNEL_CHECK(e, ...)                                               \
    do {                                                                   \
        if ((e).trap == ::meld::Trap::None && !(__VA_ARGS__)) [[unlikely]] \
            (e).host->broken(&(e), #__VA_ARGS__, __FILE__, __LINE__);      \
    } while (false)
#else
#define KERNEL_CHECK(e, ...) static_cast<void>(sizeof(!(__VA_ARGS__)))
#endif

namespace meld {

// Whether each row is less than the next one, or with ties allowed not greater. Cost: linear; for checks.
enum class Ties { None, Allowed };
template <class Row, class Less>
bool in_order(const Row* rows, u32 count, Ties ties, const Less& less) {
    for (u32 i = 1; i < count; ++i)
        if (ties == Ties::None ? !less(rows[i - 1], rows[i]) : less(rows[i], rows[i - 1])) return false;
    return true;
}

// Whether the rows of a predicate are in the order of their groups, one row a group.
template <class T>
bool one_a_group(const typename T::Row* rows, u32 count) {
    return in_order(rows, count, Ties::None, [](const auto& a, const auto& b) { return T::key(a, b) < 0; });
}

// Whether all rows are of one group.
template <class T>
bool of_one_group(const typename T::Row* rows, u32 count) {
    for (u32 i = 1; i < count; ++i)
        if (T::key(rows[0], rows[i]) != 0) return false;
    return true;
}

}  // namespace meld
