// The checks of the kernel: where they end a run, and what their conditions see.
#define MELD_CHECKED
#include "runtime/module/kernel/check.h"

#include <gtest/gtest.h>

#include <string>

namespace meld {
namespace {

std::string broken;

struct KernelCheck : testing::Test {
    KernelCheck() {
        broken.clear();
        host.broken = [](Eval*, const char* condition, const char*, i32) { broken = condition; };
        e.host = &host;
    }
    Host host{};
    Eval e{};
};

TEST_F(KernelCheck, NamesTheConditionThatDoesNotHold) {
    KERNEL_CHECK(e, 1 < 2);
    EXPECT_EQ(broken, "");
    KERNEL_CHECK(e, 2 < 1);
    EXPECT_EQ(broken, "2 < 1");
}

TEST_F(KernelCheck, PromisesNothingAfterATrap) {
    e.trap = Trap::Overflow;
    KERNEL_CHECK(e, 2 < 1);
    EXPECT_EQ(broken, "");
}

struct Grouped {
    struct Row {
        int group;
    };
    static int key(const Row& a, const Row& b) { return a.group - b.group; }
};

TEST(KernelOrder, SeesTiesAndDescents) {
    const auto less = [](int a, int b) { return a < b; };
    const int rising[] = {1, 2, 3}, tied[] = {1, 2, 2}, falling[] = {1, 3, 2};
    EXPECT_TRUE(in_order(rising, 3, Ties::None, less));
    EXPECT_FALSE(in_order(tied, 3, Ties::None, less));
    EXPECT_TRUE(in_order(tied, 3, Ties::Allowed, less));
    EXPECT_FALSE(in_order(falling, 3, Ties::Allowed, less));
    EXPECT_TRUE(in_order(falling, 0, Ties::None, less));
}

TEST(KernelOrder, SeesGroups) {
    const Grouped::Row apart[] = {{1}, {2}}, together[] = {{1}, {1}};
    EXPECT_TRUE(one_a_group<Grouped>(apart, 2));
    EXPECT_FALSE(one_a_group<Grouped>(together, 2));
    EXPECT_FALSE(of_one_group<Grouped>(apart, 2));
    EXPECT_TRUE(of_one_group<Grouped>(together, 2));
}

}  // namespace
}  // namespace meld
