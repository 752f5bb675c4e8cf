// The Hilbert curve by Skilling's transform: the index with its bits distributed over the axes is a Gray-coded cell.
#include "runtime/world/lattice/hilbert.h"

#include "runtime/base/assert.h"

namespace meld::world {
namespace {

constexpr std::uint32_t kTopBit = 1u << (kHilbertBits - 1);

// Puts two zero bits after each of the low 21 bits.
std::uint64_t spread(std::uint64_t bits) {
    bits = (bits | bits << 32) & 0x001f00000000ffff;
    bits = (bits | bits << 16) & 0x001f0000ff0000ff;
    bits = (bits | bits << 8) & 0x100f00f00f00f00f;
    bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
    bits = (bits | bits << 2) & 0x1249249249249249;
    return bits;
}

// Keeps every third bit and closes the gaps.
std::uint32_t gather(std::uint64_t bits) {
    bits &= 0x1249249249249249;
    bits = (bits | bits >> 2) & 0x10c30c30c30c30c3;
    bits = (bits | bits >> 4) & 0x100f00f00f00f00f;
    bits = (bits | bits >> 8) & 0x001f0000ff0000ff;
    bits = (bits | bits >> 16) & 0x001f00000000ffff;
    bits = (bits | bits >> 32) & 0x00000000001fffff;
    return static_cast<std::uint32_t>(bits);
}

// One level of the transform: if the bit of an axis is set, inverts the low bits of the first axis; otherwise swaps them with those of this
// axis. Without a branch, which no processor could guess.
void turn(std::array<std::uint32_t, 3>& axes, std::size_t axis, std::uint32_t bit) {
    const std::uint32_t low = bit - 1;
    const std::uint32_t set = (axes[axis] & bit) != 0 ? low : 0;
    const std::uint32_t swapped = (axes[0] ^ axes[axis]) & (low ^ set);
    axes[0] ^= set | swapped;
    axes[axis] ^= swapped;
}

}  // namespace

std::uint64_t hilbert_index(std::array<std::uint32_t, 3> axes) {
    MELD_EXPECT((axes[0] | axes[1] | axes[2]) >> kHilbertBits == 0, "place {} {} {}", axes[0], axes[1], axes[2]);
    for (std::uint32_t bit = kTopBit; bit > 1; bit >>= 1) {
        for (std::size_t axis = 0; axis < 3; ++axis) turn(axes, axis, bit);
    }
    axes[1] ^= axes[0];
    axes[2] ^= axes[1];
    std::uint32_t flips = 0;
    for (std::uint32_t bit = kTopBit; bit > 1; bit >>= 1) {
        if (axes[2] & bit) flips ^= bit - 1;
    }
    for (std::uint32_t& axis : axes) axis ^= flips;
    return spread(axes[0]) << 2 | spread(axes[1]) << 1 | spread(axes[2]);
}

std::array<std::uint32_t, 3> hilbert_place(std::uint64_t index) {
    MELD_EXPECT(index >> (3 * kHilbertBits) == 0, "index {}", index);
    std::array<std::uint32_t, 3> axes = {gather(index >> 2), gather(index >> 1), gather(index)};
    const std::uint32_t flips = axes[2] >> 1;
    axes[2] ^= axes[1];
    axes[1] ^= axes[0];
    axes[0] ^= flips;
    for (std::uint32_t bit = 2; bit <= kTopBit; bit <<= 1) {
        for (std::size_t axis = 3; axis-- > 0;) turn(axes, axis, bit);
    }
    return axes;
}

}  // namespace meld::world
