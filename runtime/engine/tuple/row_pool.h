// Memory for rows: slabs divided into power-of-two blocks, one pool per thread, so evaluation allocates without locks.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/base/raw_array.h"

namespace meld::tuple {

// A block may be freed into another pool than it came from: all pools of a process live as long as its columns.
class RowPool {
  public:
    // At least this many bytes; the capacity is what take() rounds up to.
    static std::size_t capacity(std::size_t bytes) { return std::size_t{1} << size_class(bytes); }
    std::uint8_t* take(std::size_t bytes);
    void give(std::uint8_t* block, std::size_t bytes);
    // Whether this many rows stay in a block with room for `room`: shrinking to a quarter frees memory.
    static bool fits(std::uint32_t room, std::uint32_t count, std::size_t row_bytes) {
        const std::size_t bytes = count * row_bytes, held = room * row_bytes;
        return count > 0 && bytes <= held && (bytes * 4 >= held || held <= 64);
    }
    std::size_t bytes_reserved() const { return reserved_; }

  private:
    static constexpr std::size_t kSmallest = 4;  // 16 bytes
    // Who has many slabs gets greater ones, in large pages.
    static constexpr std::size_t kSlab = 1 << 18, kLargeSlab = 4 << 20, kMany = 64 << 20;
    static std::size_t size_class(std::size_t bytes) {
        return bytes <= 16 ? kSmallest : static_cast<std::size_t>(std::bit_width(bytes - 1));
    }

    // Adds a slab, which nobody has written to.
    std::uint8_t* new_slab(std::size_t bytes);

    std::array<std::vector<std::uint8_t*>, 48> free_;
    std::vector<RawArray<std::uint8_t>> slabs_;
    std::uint8_t* next_ = nullptr;
    std::size_t left_ = 0;
    std::size_t reserved_ = 0;
};

}  // namespace meld::tuple
