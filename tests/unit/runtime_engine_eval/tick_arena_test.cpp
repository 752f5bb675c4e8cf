// Copies that do not move until the end of a tick stay as they are, in memory that ticks share, and that is given back when it is idle.
#include "runtime/engine/eval/tick_arena.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <cstdint>
#include <numeric>
#include <vector>

namespace meld::eval {
namespace {

// Bytes that this process has asked for and not given back.
std::size_t in_use() {
    const struct mallinfo2 all = mallinfo2();
    return all.uordblks + all.hblkhd;
}

// Takes so many rows of some numbers, and checks at the end that none has been overwritten. Returns where they were.
std::vector<const std::uint64_t*> fill(Kept<std::uint64_t>& kept, std::size_t rows, std::size_t length) {
    std::vector<std::uint64_t> row(length);
    std::vector<const std::uint64_t*> places;
    for (std::size_t i = 0; i < rows; ++i) {
        std::iota(row.begin(), row.end(), i);
        places.push_back(kept.copy(row.data(), length));
    }
    for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t k = 0; k < length; ++k) EXPECT_EQ(places[i][k], i + k);
    return places;
}

TEST(Kept, HoldsRowsOfAnyLengthInPlaceUntilTheEndOfTheTick) {
    Kept<std::uint64_t> kept;
    for (const std::size_t length : std::initializer_list<std::size_t>{1, 7, 100, 5'000, 200'000, 3, 40'000}) {
        fill(kept, 30, length);
        kept.clear();
    }
}

TEST(Kept, TakesTheSameMemoryInEachSteadyTick) {
    Kept<std::uint64_t> kept;
    const auto first = fill(kept, 2'000, 100);
    for (int tick = 0; tick < 5; ++tick) {
        kept.clear();
        EXPECT_EQ(fill(kept, 2'000, 100), first);
    }
}

TEST(Kept, GivesBackWhatAGreatTickHasTakenWhileTicksAreSmall) {
    Kept<std::uint64_t> kept;
    const std::size_t nothing = in_use();
    fill(kept, 2'000, 100);
    const std::size_t great = in_use() - nothing;
    EXPECT_GE(great, 2'000 * 100 * sizeof(std::uint64_t));
    for (int tick = 0; tick < 10; ++tick) {
        kept.clear();
        fill(kept, 2, 100);
    }
    EXPECT_LT(in_use() - nothing, great / 10);
    // A great tick fits again.
    kept.clear();
    fill(kept, 2'000, 100);
}

}  // namespace
}  // namespace meld::eval
