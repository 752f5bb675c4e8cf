// Where catoms stand on a lattice, as bits: which of them others surround on all sides.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/show/render/scene.h"

namespace meld::render {

// From a cube to those that it has a face with.
inline const std::array<Vec, 6> kAxes = {-Vec::UnitX(), Vec::UnitX(), -Vec::UnitY(), Vec::UnitY(), -Vec::UnitZ(), Vec::UnitZ()};

class Cells {
  public:
    // Of a scene whose catoms stand where `ways`, of length 1 and in pairs of opposite ones, lead from one to another. Nothing if they do
    // not, or if they are so far apart that bits for all cells between them would take more memory than the scene.
    // Cost: some 10 ns a catom, and 8 bytes.
    static std::optional<Cells> of(const Scene& scene, std::span<const Vec> ways);

    // Whether there is a catom next to this one, on the way of this number.
    bool has_next(std::size_t catom, std::size_t way) const { return bit(bits_, at_[catom] + ways_[way]); }
    // How many catoms one has to go through from each to the nearest place without one, counted up to `most`: 0 where there is such a place
    // next to it. Cost: a nanosecond a catom and layer.
    std::vector<std::uint8_t> depths(int most) const;

  private:
    using Bits = std::vector<std::uint64_t>;
    static bool bit(const Bits& bits, std::ptrdiff_t at) { return bits[static_cast<std::size_t>(at) / 64] >> (at % 64) & 1; }
    // Those all of whose neighbours are there too.
    Bits within(const Bits& bits) const;

    Bits bits_;                         // With an empty margin, so that a way from any cell leads to another one.
    std::vector<std::ptrdiff_t> at_;    // Of catoms, the number of their bit.
    std::vector<std::ptrdiff_t> ways_;  // How far a way leads, in bits.
};

}  // namespace meld::render
