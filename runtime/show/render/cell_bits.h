// Which cells of a lattice have a catom, as bits: whether there is one next to another, and which of them others surround on all sides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace meld::render {

class CellBits {
  public:
    CellBits() = default;
    // Of so many cells, all empty. `ways`: what leads from the number of a cell to those of its neighbours, in pairs of opposite ones.
    // Cells at the margin stay empty, so that a way from any cell with a catom leads to another one.
    CellBits(std::size_t cells, std::vector<std::ptrdiff_t> ways) : words_(cells / 64 + 1), ways_(std::move(ways)) {}

    bool has(std::ptrdiff_t cell) const { return (words_[static_cast<std::size_t>(cell) / 64] >> (cell % 64) & 1) != 0; }
    void set(std::ptrdiff_t cell) { words_[static_cast<std::size_t>(cell) / 64] |= std::uint64_t{1} << (cell % 64); }
    void clear(std::ptrdiff_t cell) { words_[static_cast<std::size_t>(cell) / 64] &= ~(std::uint64_t{1} << (cell % 64)); }
    // Whether there is a catom next to a cell, on the way of this number.
    bool has_next(std::ptrdiff_t cell, std::size_t way) const { return has(cell + ways_[way]); }
    // Those all of whose neighbours are there too.
    CellBits within() const;

  private:
    std::vector<std::uint64_t> words_;
    std::vector<std::ptrdiff_t> ways_;
};

}  // namespace meld::render
