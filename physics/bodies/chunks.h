// A list that grows without being copied, for data whose amount is unknown in advance: the items are stored in chunks, each twice as long
// as the one before up to a limit. A vector would need half as much memory again while it copies.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "physics/bodies/buffer.h"
#include "runtime/base/release_memory.h"

namespace meld::physics {

template <class T>
class Chunks {
  public:
    std::size_t size() const { return size_; }
    void push_back(const T& item) {
        if (chunks_.empty() || chunks_.back().size() == chunks_.back().capacity()) {
            const std::size_t wanted = chunks_.empty() ? kFirstItems : std::min(2 * chunks_.back().capacity(), kMaxItems);
            chunks_.emplace_back().reserve(wanted);
        }
        chunks_.back().push_back(item);
        ++size_;
    }
    template <class F>
    void each(const F& f) const {
        for (const Buffer<T>& chunk : chunks_)
            for (const T& item : chunk) f(item);
    }
    // The same, and frees what has been visited.
    template <class F>
    void consume(const F& f) {
        for (Buffer<T>& chunk : chunks_) {
            for (const T& item : chunk) f(item);
            release_memory(chunk);
        }
        chunks_.clear();
        size_ = 0;
    }

  private:
    // Chunks of this length are mapped and unmapped one by one, so consumed data is freed in small pieces; shorter chunks may stay with the
    // allocator.
    static constexpr std::size_t kMaxItems = 2 * kLargeBytes / sizeof(T);
    static constexpr std::size_t kFirstItems = 1024;
    std::vector<Buffer<T>> chunks_;
    std::size_t size_ = 0;
};

}  // namespace meld::physics
