#include "runtime/base/natural_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace meld {
namespace {

TEST(NaturalOrder, NumbersCompareAsNumbers) {
    const std::vector<std::string> ordered = {"dist(@3, -20)", "dist(@3, -3)", "dist(@3, 0)",   "dist(@3, 9)",
                                              "dist(@3, 10)",  "dist(@20, 1)", "dist(@168, 0)", "near(@1)"};
    std::vector<std::string> sorted = ordered;
    std::ranges::reverse(sorted);
    std::ranges::sort(sorted, natural_less);
    EXPECT_EQ(sorted, ordered);
}

TEST(NaturalOrder, NumbersMayHaveAnyLength) {
    EXPECT_TRUE(natural_less("99999999999999999999999", "100000000000000000000000"));
    EXPECT_TRUE(natural_less("a10000000000", "a99999999999"));
}

TEST(NaturalOrder, AMinusAfterAWordIsNoSign) {
    EXPECT_TRUE(natural_less("tree-2(@0)", "tree-10(@0)"));
    EXPECT_TRUE(natural_less("(-10)", "(-2)"));
}

TEST(NaturalOrder, ItIsTotal) {
    // Equal as numbers, and yet different texts.
    EXPECT_NE(natural_less("a01", "a1"), natural_less("a1", "a01"));
    EXPECT_TRUE(natural_less("a", "ab"));
    EXPECT_FALSE(natural_less("a", "a"));
    EXPECT_TRUE(natural_less("", "0"));
}

TEST(NaturalOrder, ItIsTransitive) {
    const std::vector<std::string> all = {"", "-", "-1", "-01", "1", "01", "a-1", "a1", "a-", "1-1", "--1", "-a", "1a", "-10", "10", "a10"};
    for (const std::string& a : all)
        for (const std::string& b : all)
            for (const std::string& c : all) {
                if (!natural_less(a, b) || !natural_less(b, c)) continue;
                EXPECT_TRUE(natural_less(a, c)) << a << " " << b << " " << c;
            }
}

}  // namespace
}  // namespace meld
