#include "runtime/base/hash.h"

#include <gtest/gtest.h>
#include <bit>
#include <set>
#include <vector>

namespace meld {
namespace {

TEST(Hash, MixesEveryInputBitIntoHalfOfTheOutput) {
    for (int bit = 0; bit < 64; ++bit) {
        int flipped = 0;
        for (std::uint64_t x = 1; x <= 256; ++x) flipped += std::popcount(mix64(x * 77) ^ mix64((x * 77) ^ (std::uint64_t{1} << bit)));
        EXPECT_NEAR(flipped / 256.0, 32.0, 2.5) << "bit " << bit;
    }
}

TEST(Hash, CombineDependsOnOrder) { EXPECT_NE(hash_combine(hash_combine(0, 1), 2), hash_combine(hash_combine(0, 2), 1)); }

TEST(Hash, BytesAreHashedByXxh3) {
    EXPECT_EQ(hash_text(""), 0x2d06800538d394c2u);  // The published value of XXH3_64bits of nothing.
    EXPECT_NE(hash_text("meld"), hash_text("melD"));
    EXPECT_NE(hash_text("meld", 1), hash_text("meld", 2));
}

TEST(Digest, IsIndifferentToOrderAndGrouping) {
    Digest forward, left, right;
    for (std::uint64_t i = 0; i < 100; ++i) forward.add(i);
    for (std::uint64_t i = 100; i-- > 0;) (i % 3 == 0 ? left : right).add(i);
    right.combine(left);
    EXPECT_EQ(forward, right);
}

TEST(Digest, CountsCopies) {
    Digest once, twice;
    once.add(7);
    twice.add(7);
    twice.add(7);
    EXPECT_NE(once, twice);
    twice.remove(7);
    EXPECT_EQ(once, twice);
}

TEST(Digest, ForgetsWhatIsTakenOut) {
    Digest digest;
    const std::vector<std::byte> bytes(33, std::byte{5});
    digest.add_bytes(bytes);
    digest.add(0);
    EXPECT_NE(digest, Digest());
    digest.remove(0);
    digest.remove_bytes(bytes);
    EXPECT_EQ(digest, Digest());
}

TEST(Digest, TellsSmallSetsApart) {
    std::set<std::string> seen;
    for (std::uint64_t a = 0; a < 60; ++a) {
        for (std::uint64_t b = a; b < 60; ++b) {
            Digest digest;
            digest.add(a);
            digest.add(b);
            EXPECT_TRUE(seen.insert(digest.to_string()).second);
        }
    }
}

TEST(Digest, PrintsThirtyTwoDigits) { EXPECT_EQ(Digest(0xabc, 0x1).to_string(), "00000000000000010000000000000abc"); }

}  // namespace
}  // namespace meld
