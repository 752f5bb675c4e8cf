// Arrays for which nobody writes before whoever fills them: growing one touches no memory, so that threads may share the first touch, which
// is when the system finds and clears each page.
#pragma once

#include <new>
#include <utility>
#include <vector>

#include "runtime/base/large_array.h"

namespace meld {

template <class T>
struct RawAllocator : LargeAllocator<T> {
    template <class U>
    struct rebind {
        using other = RawAllocator<U>;
    };
    template <class U>
    void construct(U* item) noexcept {
        ::new (static_cast<void*>(item)) U;
    }
    template <class U, class... Arguments>
    void construct(U* item, Arguments&&... arguments) {
        ::new (static_cast<void*>(item)) U(std::forward<Arguments>(arguments)...);
    }
};

// A vector of numbers whose resize(n) leaves new items undefined; resize(n, value) sets them as always.
template <class T>
using RawArray = std::vector<T, RawAllocator<T>>;

}  // namespace meld
