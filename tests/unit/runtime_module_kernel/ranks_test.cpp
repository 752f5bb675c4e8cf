#include "runtime/module/kernel/views.h"

#include <gtest/gtest.h>

namespace meld {
namespace {

TEST(Ranks, EndTheRunAboveTheMaximum) {
    Eval e;
    note_rank(e, kMaxRank);
    EXPECT_EQ(e.trap, Trap::None);
    EXPECT_EQ(e.greatest_rank, kMaxRank);
    e.rule = 3;
    note_rank(e, kMaxRank + 1);
    EXPECT_EQ(e.trap, Trap::RankTooHigh);
    EXPECT_TRUE(is_limit(e.trap));
    EXPECT_EQ(e.trap_rule, 3U);
}

}  // namespace
}  // namespace meld
