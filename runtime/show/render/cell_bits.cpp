#include "runtime/show/render/cell_bits.h"

namespace meld::render {

CellBits CellBits::within() const {
    CellBits out = *this;
    const auto words = static_cast<std::ptrdiff_t>(words_.size());
    for (const std::ptrdiff_t way : ways_) {
        // The bit of the neighbour comes to the place of the catom.
        const std::ptrdiff_t shift = way >= 0 ? way / 64 : -((-way + 63) / 64), rest = way - 64 * shift;
        const auto word = [&](std::ptrdiff_t i) { return i >= 0 && i < words ? words_[static_cast<std::size_t>(i)] : 0; };
        for (std::ptrdiff_t i = 0; i < words; ++i) {
            std::uint64_t& here = out.words_[static_cast<std::size_t>(i)];
            if (here == 0) continue;
            const std::uint64_t next = rest == 0 ? 0 : word(i + shift + 1) << (64 - rest);
            here &= word(i + shift) >> rest | next;
        }
    }
    return out;
}

}  // namespace meld::render
