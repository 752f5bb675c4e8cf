// Sorts indices by a 32-bit key in linear time: for lists that are rebuilt every tick.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace meld {

struct Keyed {
    std::uint32_t key;
    std::uint32_t place;
};

// Sorts by key; indices with equal keys keep their order. Short lists are sorted by the standard library; longer ones byte by byte from the
// lowest, skipping bytes that all keys share. `spare` is memory that may be reused between calls.
inline void sort_by_key(std::vector<Keyed>& list, std::vector<Keyed>& spare) {
    constexpr std::size_t kShort = 512;
    if (list.size() < kShort) {
        std::stable_sort(list.begin(), list.end(), [](const Keyed& a, const Keyed& b) { return a.key < b.key; });
        return;
    }
    spare.resize(list.size());
    std::array<std::array<std::uint32_t, 256>, 4> counts{};
    for (const Keyed& k : list)
        for (unsigned byte = 0; byte < 4; ++byte) ++counts[byte][k.key >> (8 * byte) & 255];
    for (unsigned shift = 0; shift < 32; shift += 8) {
        std::array<std::uint32_t, 256>& starts = counts[shift / 8];
        if (starts[list[0].key >> shift & 255] == list.size()) continue;
        std::uint32_t at = 0;
        for (std::uint32_t& start : starts) {
            const std::uint32_t count = start;
            start = at;
            at += count;
        }
        for (const Keyed& k : list) spare[starts[k.key >> shift & 255]++] = k;
        list.swap(spare);
    }
}

}  // namespace meld
