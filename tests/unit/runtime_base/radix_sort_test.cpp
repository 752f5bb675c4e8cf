#include "runtime/base/radix_sort.h"

#include <gtest/gtest.h>

#include <random>

namespace meld {
namespace {

TEST(RadixSort, KeepsTheOrderOfEqualKeysAtAnyLength) {
    std::mt19937 random(7);
    std::vector<Keyed> spare;
    for (const std::uint32_t greatest : {0u, 3u, 255u, 70'000u, 0xffffffffu})
        for (const std::size_t length :
             {std::size_t{0}, std::size_t{1}, std::size_t{511}, std::size_t{512}, std::size_t{513}, std::size_t{20000}}) {
            std::vector<Keyed> list, expected;
            for (std::uint32_t i = 0; i < length; ++i) list.push_back({static_cast<std::uint32_t>(random() & greatest), i});
            expected = list;
            std::stable_sort(expected.begin(), expected.end(), [](const Keyed& a, const Keyed& b) { return a.key < b.key; });
            sort_by_key(list, spare);
            ASSERT_EQ(list.size(), expected.size());
            for (std::size_t i = 0; i < length; ++i)
                ASSERT_TRUE(list[i].key == expected[i].key && list[i].place == expected[i].place) << length << " at " << i;
        }
}

}  // namespace
}  // namespace meld
