#include "runtime/world/lattice/hilbert.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <set>

namespace meld::world {
namespace {

using Place = std::array<std::uint32_t, 3>;

TEST(Hilbert, ComesBackFromEachIndex) {
    std::mt19937_64 random(3);
    for (int i = 0; i < 10'000; ++i) {
        const std::uint64_t index = random() >> (64 - 3 * kHilbertBits);
        EXPECT_EQ(hilbert_index(hilbert_place(index)), index);
    }
    const std::uint32_t last = (1u << kHilbertBits) - 1;
    for (const Place place : {Place{0, 0, 0}, Place{last, 0, 0}, Place{last, last, last}, Place{0, last, 7}}) {
        EXPECT_EQ(hilbert_place(hilbert_index(place)), place);
    }
}

TEST(Hilbert, GoesFromEachPlaceToAnAdjacentOne) {
    std::mt19937_64 random(4);
    for (int run = 0; run < 20; ++run) {
        const std::uint64_t start = (random() >> (64 - 3 * kHilbertBits)) / 2;
        Place before = hilbert_place(start);
        for (std::uint64_t i = 1; i < 1'000; ++i) {
            const Place here = hilbert_place(start + i);
            int steps = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) steps += std::abs(static_cast<int>(here[axis]) - static_cast<int>(before[axis]));
            EXPECT_EQ(steps, 1);
            before = here;
        }
    }
}

TEST(Hilbert, FillsAlignedCubesWithOneRange) {
    const std::uint64_t start = std::uint64_t{0x2a5b} << 12;
    std::set<Place> corners;
    std::set<Place> places;
    for (std::uint64_t i = 0; i < 4096; ++i) {
        const Place place = hilbert_place(start + i);
        places.insert(place);
        corners.insert({place[0] >> 4, place[1] >> 4, place[2] >> 4});
    }
    EXPECT_EQ(places.size(), 4096u);
    EXPECT_EQ(corners.size(), 1u);
}

}  // namespace
}  // namespace meld::world
