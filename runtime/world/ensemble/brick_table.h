// Hash tables of an ensemble: brick coordinates to slots, and catom ids to indices. Open addressing, linear probing.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/world/lattice/lattice.h"

namespace meld::world {

// Brick coordinates, 18 bits each and offset to be positive, as one number.
inline std::uint64_t packed(Cell brick) {
    constexpr int kBits = 18;
    const auto part = [](std::int32_t value) { return static_cast<std::uint64_t>(value + (1 << (kBits - 1))); };
    return part(brick.x) | part(brick.y) << kBits | part(brick.z) << 2 * kBits;
}

// From a packed brick coordinate to its slot. Bricks are never removed; slot 0 means absent.
class BrickTable {
  public:
    std::uint32_t find(std::uint64_t key) const;
    // The key must be absent.
    void insert(std::uint64_t key, std::uint32_t slot);
    void reserve(std::size_t count);
    std::size_t bytes() const { return rows_.capacity() * sizeof(Row); }
    static std::size_t bytes_for(std::size_t count) { return rows_for(count) * sizeof(Row); }

  private:
    static std::size_t rows_for(std::size_t count) { return std::bit_ceil(2 * count + 2); }
    struct Row {
        std::uint64_t key = 0;
        std::uint32_t slot = 0;
    };
    void place(Row row);
    void grow(std::size_t rows);
    std::vector<Row> rows_;
    std::size_t used_ = 0;
};

// From a catom's id to its index, in 4 bytes per row: the id itself is read from the ensemble's column, which every call is given.
class IdTable {
  public:
    static constexpr std::uint32_t kAbsent = 0xffffffff;
    std::uint32_t find(std::uint64_t id, std::span<const std::uint64_t> ids) const;
    // ids[index] must be set, and the id absent.
    void insert(std::uint32_t index, std::span<const std::uint64_t> ids);
    // ids[index] must still be set.
    void erase(std::uint32_t index, std::span<const std::uint64_t> ids);
    void reserve(std::size_t count, std::span<const std::uint64_t> ids);
    // All indices are greater by this from now on.
    void shift(std::uint32_t by);
    std::size_t bytes() const { return rows_.capacity() * sizeof(std::uint32_t); }

  private:
    void place(std::uint32_t index, std::span<const std::uint64_t> ids);
    std::vector<std::uint32_t> rows_;
    std::size_t used_ = 0;
};

}  // namespace meld::world
