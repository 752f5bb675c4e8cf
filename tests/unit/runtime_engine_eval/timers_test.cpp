#include <gtest/gtest.h>

#include <map>

#include "runtime/engine/eval/timers.h"

namespace meld::eval {
namespace {

std::map<u32, u64> fired(Timers& timers, i64 now) {
    std::map<u32, u64> all;
    timers.fire(now, [&](u32 catom, u64 bits) { all[catom] |= bits; }, [](u32, u16, const u8*) {});
    return all;
}

TEST(Timers, MarkCatomsWhenTheTimeHasCome) {
    Timers timers;
    timers.add(1, 4, 7, 8);
    timers.add(2, 3, 9, 8);
    EXPECT_TRUE(fired(timers, 2).empty());
    EXPECT_EQ(fired(timers, 3), (std::map<u32, u64>{{9, 8}}));
    EXPECT_EQ(fired(timers, 4), (std::map<u32, u64>{{7, 8}}));
    EXPECT_TRUE(timers.empty());
}

// In tick 6 a catom comes from another process with its timers and is removed, and another one takes its index.
TEST(Timers, OfACatomThatCameAndWentInOneTickAreNotForTheNextOne) {
    Timers timers;
    timers.add(6, 9, 1, 8);
    timers.forget(1);
    EXPECT_TRUE(fired(timers, 9).empty());
    timers.add(10, 12, 2, 8);
    timers.forget(1);
    timers.add(10, 12, 1, 8);
    EXPECT_EQ(fired(timers, 12), (std::map<u32, u64>{{1, 8}, {2, 8}}));
}

}  // namespace
}  // namespace meld::eval
