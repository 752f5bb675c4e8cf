// An array of plain values that grows by an eighth, in place where the system can: what is large is neither copied nor cleared again.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

namespace meld {

template <class T>
class PlainArray {
  public:
    static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T> && alignof(T) <= alignof(std::max_align_t));

    PlainArray() = default;
    PlainArray(PlainArray&& other) noexcept { swap(other); }
    PlainArray& operator=(PlainArray&& other) noexcept {
        swap(other);
        return *this;
    }
    PlainArray(const PlainArray&) = delete;
    PlainArray& operator=(const PlainArray&) = delete;
    ~PlainArray() { std::free(data_); }

    std::size_t size() const { return size_; }
    std::size_t capacity() const { return capacity_; }
    bool empty() const { return size_ == 0; }
    T* begin() { return data_; }
    T* end() { return data_ + size_; }
    const T* begin() const { return data_; }
    const T* end() const { return data_ + size_; }
    T& operator[](std::size_t i) { return data_[i]; }
    const T& operator[](std::size_t i) const { return data_[i]; }
    std::span<const T> view() const { return {data_, size_}; }

    // Adds one, and returns its place, which is to be written.
    T* add() {
        if (size_ == capacity_) [[unlikely]]
            grow();
        return data_ + size_++;
    }
    // The first so many stay.
    void truncate(std::size_t size) { size_ = size; }
    // The memory stays.
    void clear() { size_ = 0; }
    void swap(PlainArray& other) noexcept {
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        std::swap(capacity_, other.capacity_);
    }

  private:
    [[gnu::noinline]] void grow() {
        constexpr std::size_t kLeast = 64, kShare = 8;
        const std::size_t capacity = capacity_ + capacity_ / kShare + kLeast;
        void* const bigger = std::realloc(static_cast<void*>(data_), capacity * sizeof(T));
        // What `new` does then.
        if (bigger == nullptr) throw std::bad_alloc();
        data_ = static_cast<T*>(bigger);
        capacity_ = capacity;
    }

    T* data_ = nullptr;
    std::size_t size_ = 0, capacity_ = 0;
};

// Removes those for which it is true, and returns how many.
template <class T, class Is>
std::size_t erase_if(PlainArray<T>& all, const Is& is) {
    T* to = all.begin();
    for (const T& each : all)
        if (!is(each)) *to++ = each;
    const std::size_t removed = static_cast<std::size_t>(all.end() - to);
    all.truncate(all.size() - removed);
    return removed;
}

}  // namespace meld
