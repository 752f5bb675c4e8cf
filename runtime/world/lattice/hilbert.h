// The three-dimensional Hilbert curve over 2^18 steps per axis: consecutive indices are adjacent cells.
#pragma once

#include <array>
#include <cstdint>

namespace meld::world {

inline constexpr int kHilbertBits = 18;

// The index of a cell along the curve, below 2^54, and back. Coordinates are below 2^18. Both directions are exact.
// After J. Skilling, "Programming the Hilbert curve", AIP Conference Proceedings 707 (2004), 381-387.
std::uint64_t hilbert_index(std::array<std::uint32_t, 3> place);
std::array<std::uint32_t, 3> hilbert_place(std::uint64_t index);

}  // namespace meld::world
