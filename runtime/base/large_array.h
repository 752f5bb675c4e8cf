// Memory for arrays of many megabytes, which the system gives in large pages where it can. A page costs as much as a hundred numbers or
// more when it is touched for the first time; and where arrays are read here and there, the processor finds the place of a large page far
// more often without a search. What is touched counts with its whole page, so this is for arrays that are filled.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <new>
#include <vector>

namespace meld {

inline constexpr std::size_t kLargePageBytes = 2 << 20;
// Less than this is not worth it.
inline constexpr std::size_t kFewestLargeBytes = 2 * kLargePageBytes;

// Asks for large pages for those that lie in this memory as a whole. What the system says to this changes nothing but the time.
inline void ask_for_large_pages(void* memory, std::size_t bytes) {
    if (memory == nullptr || bytes < kFewestLargeBytes) return;
    const auto from = (reinterpret_cast<std::uintptr_t>(memory) + kLargePageBytes - 1) / kLargePageBytes * kLargePageBytes;
    const auto to = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / kLargePageBytes * kLargePageBytes;
    if (from < to) static_cast<void>(madvise(reinterpret_cast<void*>(from), to - from, MADV_HUGEPAGE));
}

// Memory from malloc, aligned so that it consists of large pages where it is large; nullptr if there is none.
inline void* allocate_large(std::size_t bytes) {
    if (bytes < kFewestLargeBytes) return std::malloc(bytes);
    void* memory = nullptr;
    if (posix_memalign(&memory, kLargePageBytes, bytes) != 0) return nullptr;
    ask_for_large_pages(memory, bytes);
    return memory;
}

// A vector of it is a LargeArray.
template <class T>
class LargeAllocator {
  public:
    using value_type = T;
    LargeAllocator() = default;
    template <class Other>
    LargeAllocator(const LargeAllocator<Other>&) {}  // NOLINT(google-explicit-constructor): as allocators are converted.

    T* allocate(std::size_t count) {
        if (count > std::numeric_limits<std::size_t>::max() / sizeof(T)) throw std::bad_array_new_length();
        void* const memory = allocate_large(std::max<std::size_t>(1, count * sizeof(T)));
        if (memory == nullptr) throw std::bad_alloc();
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, std::size_t) { std::free(memory); }
    bool operator==(const LargeAllocator&) const { return true; }
};

template <class T>
using LargeArray = std::vector<T, LargeAllocator<T>>;

}  // namespace meld
