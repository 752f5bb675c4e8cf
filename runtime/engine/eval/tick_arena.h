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

// Pointers are valid until clear(). A steady tick allocates nothing. Chunks that ticks no longer need are given back little by little.
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
            take_chunk(count);
        T* to = next_;
        next_ += count;
        left_ -= count;
        return to;
    }
    void clear() {
        chunks_.resize(used_ + (chunks_.size() - used_) / 2);
        used_ = 0;
        next_ = nullptr;
        left_ = 0;
    }

  private:
    // Great ones are not grown further: what is not filled of the last one is memory all the same.
    static constexpr std::size_t kFirstChunk = 4096 / sizeof(T), kLargestChunk = (std::size_t{1} << 18) / sizeof(T);
    struct Chunk {
        std::unique_ptr<T[]> data;
        std::size_t size = 0;
    };
    [[gnu::noinline]] void take_chunk(std::size_t count) {
        if (used_ == chunks_.size() || chunks_[used_].size < count) {
            const std::size_t before = used_ == 0 ? 0 : chunks_[used_ - 1].size;
            const std::size_t size = std::max({count, std::min(2 * before, kLargestChunk), kFirstChunk});
            chunks_.insert(chunks_.begin() + static_cast<std::ptrdiff_t>(used_), Chunk{std::make_unique_for_overwrite<T[]>(size), size});
        }
        next_ = chunks_[used_].data.get();
        left_ = chunks_[used_].size;
        ++used_;
    }

    std::vector<Chunk> chunks_;
    std::size_t used_ = 0;  // Chunks of this tick, from the first on.
    T* next_ = nullptr;
    std::size_t left_ = 0;  // Of the last chunk.
};

}  // namespace meld::eval
