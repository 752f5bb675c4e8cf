// Copies that do not move until the end of a tick: data that a worker sets aside while it evaluates.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <type_traits>
#include <vector>

#include "runtime/base/assert.h"

namespace meld::eval {

// Pointers are valid until clear(). A steady tick allocates nothing: the largest chunk is kept.
template <class T>
class Kept {
    static_assert(std::is_trivially_copyable_v<T>);

  public:
    T* copy(const T* from, std::size_t count) {
        MELD_EXPECT(from != nullptr || count == 0);
        T* to = take(count);
        if (count > 0) std::memcpy(to, from, count * sizeof(T));
        return to;
    }
    // Room that the caller fills.
    T* take(std::size_t count) {
        if (left_ < count) [[unlikely]]
            grow(count);
        T* to = next_;
        next_ += count;
        left_ -= count;
        return to;
    }
    void clear() {
        if (chunks_.size() > 1) chunks_.erase(chunks_.begin(), chunks_.end() - 1);
        next_ = chunks_.empty() ? nullptr : chunks_.back().get();
        left_ = size_;
    }

  private:
    static constexpr std::size_t kFirstChunk = 4096 / sizeof(T);
    [[gnu::noinline]] void grow(std::size_t count) {
        size_ = std::max({count, 2 * size_, kFirstChunk});
        chunks_.push_back(std::make_unique_for_overwrite<T[]>(size_));
        next_ = chunks_.back().get();
        left_ = size_;
    }

    std::vector<std::unique_ptr<T[]>> chunks_;
    T* next_ = nullptr;
    std::size_t left_ = 0, size_ = 0;  // Of the last chunk.
};

}  // namespace meld::eval
