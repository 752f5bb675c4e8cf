// A vector for large arrays: new elements are not initialized, so that the threads that fill it are the first to touch it. Its memory is in
// huge pages if the system provides them (this saves a fifth of a tick of a million bodies).
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace meld::physics {

// Memory for large arrays, aligned to huge pages; throws std::bad_alloc.
void* allocate_large(std::size_t bytes);
// `bytes` is the number that was asked for.
void free_large(void* memory, std::size_t bytes);
inline constexpr std::size_t kLargeBytes = std::size_t{4} << 20;

template <class T>
struct UninitializedAllocator : std::allocator<T> {
    template <class U>
    struct rebind {
        using other = UninitializedAllocator<U>;
    };
    T* allocate(std::size_t count) {
        if (count * sizeof(T) < kLargeBytes) return std::allocator<T>::allocate(count);
        return static_cast<T*>(allocate_large(count * sizeof(T)));
    }
    void deallocate(T* memory, std::size_t count) {
        if (count * sizeof(T) < kLargeBytes) return std::allocator<T>::deallocate(memory, count);
        free_large(memory, count * sizeof(T));
    }
    template <class U>
    void construct(U* place) noexcept(std::is_nothrow_default_constructible_v<U>) {
        ::new (static_cast<void*>(place)) U;
    }
    template <class U, class... Arguments>
    void construct(U* place, Arguments&&... arguments) {
        std::construct_at(place, std::forward<Arguments>(arguments)...);
    }
};

template <class T>
using Buffer = std::vector<T, UninitializedAllocator<T>>;

// Returns the pages of a large array up to entry `end`, which are no longer used, to the system; they read as zeros from then on.
// `gone_bytes` have been returned before; the result is the total returned by now.
std::size_t give_back_pages(void* memory, std::size_t gone_bytes, std::size_t end_bytes);
template <class T>
std::size_t give_back_front(Buffer<T>& array, std::size_t gone_bytes, std::size_t end) {
    if (array.capacity() * sizeof(T) < kLargeBytes) return 0;
    return give_back_pages(array.data(), gone_bytes, end * sizeof(T));
}

}  // namespace meld::physics
