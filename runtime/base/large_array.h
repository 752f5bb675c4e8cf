// A vector for arrays of many megabytes, which the system gives in large pages where it can: a page costs as much as a hundred numbers or
// more when it is touched for the first time.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <limits>
#include <new>
#include <vector>

namespace meld {

template <class T>
class LargeAllocator {
  public:
    using value_type = T;
    LargeAllocator() = default;
    template <class Other>
    LargeAllocator(const LargeAllocator<Other>&) {}  // NOLINT(google-explicit-constructor): as allocators are converted.

    T* allocate(std::size_t count) {
        if (count > std::numeric_limits<std::size_t>::max() / sizeof(T)) throw std::bad_array_new_length();
        const std::size_t bytes = count * sizeof(T);
        if (bytes < kFewestBytes) return static_cast<T*>(::operator new(bytes));
        void* memory = nullptr;
        if (posix_memalign(&memory, kPageBytes, bytes) != 0) throw std::bad_alloc();
        // The rest of the last page is not ours. What the system says to this changes nothing but the time.
        static_cast<void>(madvise(memory, bytes / kPageBytes * kPageBytes, MADV_HUGEPAGE));
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, std::size_t count) {
        if (count * sizeof(T) < kFewestBytes)
            ::operator delete(memory);
        else
            std::free(memory);
    }
    bool operator==(const LargeAllocator&) const { return true; }

  private:
    static constexpr std::size_t kPageBytes = 2 << 20, kFewestBytes = 2 * kPageBytes;
};

template <class T>
using LargeArray = std::vector<T, LargeAllocator<T>>;

}  // namespace meld
