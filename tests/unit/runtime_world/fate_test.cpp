// What becomes of messages, drawn one by one and for several links together.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "runtime/base/random.h"
#include "runtime/world/description/network.h"

namespace meld::world {
namespace {

TEST(Fate, IsTheSameForLinksTogetherAndOneByOne) {
    std::vector<std::uint64_t> to;
    for (std::uint64_t i = 0; i < 37; ++i) to.push_back(i * i + 5);
    const LinkTerms steady, varied{.least = 2, .most = 9};
    const LinkTerms lost{.least = 1, .most = 4, .loss = 0.6, .retry = 3, .tries = 4, .duplicate = 0.5, .reorder = true};
    int gone = 0, twice = 0;
    for (const NetworkKind kind : {NetworkKind::Ideal, NetworkKind::Latency, NetworkKind::Lossy, NetworkKind::Raw})
        for (const LinkTerms& terms : {steady, varied, lost})
            for (std::int64_t tick = 1; tick < 20; ++tick) {
                std::vector<Fate> together(to.size());
                fates(kind, terms, 7, 3, to, tick, together);
                for (std::size_t i = 0; i < to.size(); ++i) {
                    const Fate alone = fate(kind, terms, 7, 3, to[i], tick);
                    EXPECT_EQ(together[i].arrives, alone.arrives);
                    EXPECT_EQ(together[i].ticks, alone.ticks);
                    EXPECT_EQ(together[i].twice_after, alone.twice_after);
                    gone += alone.arrives ? 0 : 1;
                    twice += alone.twice_after != 0 ? 1 : 0;
                }
            }
    EXPECT_GT(gone, 100);
    EXPECT_GT(twice, 100);
}

TEST(Fate, FollowsFromTheSameBits) {
    const std::array<std::uint64_t, 3> b = {4, 1000, 77};
    std::array<std::uint64_t, 3> bits;
    random_bits(9, 2, b, 31, bits);
    for (std::size_t i = 0; i < b.size(); ++i) EXPECT_EQ(bits[i], random_bits(9, 2, b[i], 31));
}

}  // namespace
}  // namespace meld::world
