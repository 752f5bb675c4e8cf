// A vector whose new elements are not initialized, so that the threads that fill a large array are the first to touch it.
#pragma once

#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace meld::physics {

template <class T>
struct UninitializedAllocator : std::allocator<T> {
    template <class U>
    struct rebind {
        using other = UninitializedAllocator<U>;
    };
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

}  // namespace meld::physics
