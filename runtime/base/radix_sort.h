// Sorts places by a 32-bit key in time proportional to their number: for lists that are rebuilt every tick.
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

// Sorts by key, places with equal keys in the order they stand in. Short lists go through the standard library; longer
// ones byte by byte from the lowest, leaving out bytes that all keys share. `spare` is room that may be kept between calls.
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
