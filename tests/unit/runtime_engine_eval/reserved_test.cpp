// Memory for what grows while a catom is evaluated is zeroed, lasts as long as the catom is evaluated, and is given back.
#include "runtime/engine/eval/reserved.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <string>

namespace meld::eval {
namespace {

// The pages of this process in memory.
u64 resident() {
    std::ifstream in("/proc/self/statm");
    u64 all = 0, here = 0;
    in >> all >> here;
    return here;
}
constexpr u64 kMega = 1 << 20;

u8* take(Reserved& reserved, u32 catom, u64 bytes) { return static_cast<u8*>(reserved.take(catom, bytes)); }

TEST(Reserved, IsZeroedAndOfOneCatomAtATime) {
    Reserved reserved;
    for (const u32 catom : {7u, 7u, 8u}) {
        u8* const first = take(reserved, catom, 3 * kMega);
        u8* const second = take(reserved, catom, 5);
        for (u8* const one : {first, second}) ASSERT_NE(one, nullptr);
        EXPECT_TRUE(std::all_of(first, first + 3 * kMega, [](u8 b) { return b == 0; }));
        EXPECT_EQ(second[4], 0);
        std::fill(first, first + 3 * kMega, u8{1});
        reserved.give_back(first);
        second[4] = 2;
        reserved.give_back(second + 1);
        EXPECT_EQ(second[4], 2);
    }
}

TEST(Reserved, TakesWhatIsWrittenTo) {
    Reserved reserved;
    const u64 before = resident();
    // Sixteen times what is written to.
    u8* const much = take(reserved, 0, 256 * kMega);
    ASSERT_NE(much, nullptr);
    std::fill(much, much + 16 * kMega, u8{1});
    const u64 pages = 16 * kMega / 4096;
    EXPECT_GE(resident(), before + pages / 2);
    EXPECT_LE(resident(), before + 2 * pages);
    reserved.take(1, 1);
    EXPECT_LE(resident(), before + pages / 4);
}

TEST(Reserved, IsRefusedWhereThereIsNoRoomAndGoesOn) {
    Reserved reserved;
    u8* const first = take(reserved, 0, kMega);
    ASSERT_NE(first, nullptr);
    first[0] = 1;
    // More than addresses reach.
    EXPECT_EQ(take(reserved, 0, u64{1} << 60), nullptr);
    EXPECT_EQ(first[0], 1);
    EXPECT_NE(take(reserved, 0, kMega), nullptr);
    // More than there is, which a kernel refuses only if it counts what it has promised (/proc/sys/vm/overcommit_memory).
    int counts = 0;
    std::ifstream("/proc/sys/vm/overcommit_memory") >> counts;
    if (counts != 2) {
        EXPECT_NE(take(reserved, 0, u64{1} << 36), nullptr);
    }
}

TEST(Reserved, IsEmptiedAndItsPlaceStays) {
    Reserved reserved;
    const u64 before = resident();
    std::set<u8*> places;
    for (int i = 0; i < 60; ++i) {
        u8* const rows = take(reserved, 0, 4 * kMega);
        ASSERT_NE(rows, nullptr);
        EXPECT_TRUE(places.insert(rows).second);
        std::fill(rows, rows + 4 * kMega, u8{1});
        reserved.empty(rows);
    }
    // Not 240 of them.
    EXPECT_LE(resident(), before + 16 * kMega / 4096);
    reserved.clear();
}

}  // namespace
}  // namespace meld::eval
