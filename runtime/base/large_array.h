// Memory for arrays of many megabytes, which the system gives in large pages where it can. A page costs as much as a hundred numbers or
// more when it is touched for the first time; and where arrays are read here and there, the processor finds the place of a large page far
// more often without a search. What is touched counts with its whole page, so this is for arrays that are filled.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace meld {

// Less than this is not worth it: two large pages.
inline constexpr std::size_t kLargeBytes = std::size_t{4} << 20;

// Asks for large pages for those that lie in this memory as a whole. What the system says to this changes nothing but the time.
void ask_for_large_pages(void* memory, std::size_t bytes);

// Memory that begins with a large page. If there is none, what `new` does then.
void* allocate_large(std::size_t bytes);
// `bytes` is the number that was asked for.
void free_large(void* memory, std::size_t bytes);

// A vector of it is a LargeArray.
template <class T>
class LargeAllocator {
  public:
    using value_type = T;
    LargeAllocator() = default;
    template <class Other>
    LargeAllocator(const LargeAllocator<Other>&) {}  // NOLINT(google-explicit-constructor): as allocators are converted.

    // A vector never asks for more than there are addresses.
    T* allocate(std::size_t count) {
        if (count < kLargeBytes / sizeof(T)) return std::allocator<T>().allocate(count);
        return static_cast<T*>(allocate_large(count * sizeof(T)));
    }
    void deallocate(T* memory, std::size_t count) {
        if (count < kLargeBytes / sizeof(T)) return std::allocator<T>().deallocate(memory, count);
        free_large(memory, count * sizeof(T));
    }
    bool operator==(const LargeAllocator&) const { return true; }
};

template <class T>
using LargeArray = std::vector<T, LargeAllocator<T>>;

}  // namespace meld
