// A vector for large arrays: new elements are not initialized, so that the threads that fill it are the first to touch it. Its memory is in
// huge pages if the system provides them (this saves a fifth of a tick of a million bodies).
#pragma once

#include <cstddef>

#include "runtime/base/large_array.h"
#include "runtime/base/raw_array.h"

namespace meld::physics {

template <class T>
using Buffer = RawArray<T>;

// Returns the pages of a large array up to entry `end`, which are no longer used, to the system; they read as zeros from then on.
// `gone_bytes` have been returned before; the result is the total returned by now.
std::size_t give_back_pages(void* memory, std::size_t gone_bytes, std::size_t end_bytes);
template <class T>
std::size_t give_back_front(Buffer<T>& array, std::size_t gone_bytes, std::size_t end) {
    if (array.capacity() * sizeof(T) < kLargeBytes) return 0;
    return give_back_pages(array.data(), gone_bytes, end * sizeof(T));
}

}  // namespace meld::physics
