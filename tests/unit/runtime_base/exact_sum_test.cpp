#include "runtime/base/exact_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace meld {
namespace {

double sum_of(const std::vector<double>& terms) {
    ExactSum sum;
    for (const double term : terms) sum.add(term);
    return sum.value();
}

TEST(ExactSum, DoesNotDependOnTheOrder) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> mantissa(-1, 1), exponent(-60, 40);
    std::vector<double> terms;
    for (int i = 0; i < 1000; ++i) terms.push_back(std::exp2(exponent(random)) * mantissa(random));
    const double expected = sum_of(terms);
    for (int i = 0; i < 20; ++i) {
        std::shuffle(terms.begin(), terms.end(), random);
        ASSERT_EQ(sum_of(terms), expected);
        ExactSum first, second;
        for (std::size_t k = 0; k < terms.size(); ++k) (k % 3 == 0 ? first : second).add(terms[k]);
        first.add(second);
        ASSERT_EQ(first.value(), expected);
    }
}

TEST(ExactSum, LosesNothingBetweenItsLimits) {
    const double small = 0x1p-80, large = 0x1p40;
    EXPECT_EQ(sum_of({large, small, -large}), small);
    EXPECT_EQ(sum_of({-small, large, -large}), -small);
    EXPECT_EQ(sum_of({0x1.23456789abcdep-3, 0x1p-17, -0x1p-17}), 0x1.23456789abcdep-3);
    // What is finer is cut off, towards zero; what is beyond counts as the limit.
    EXPECT_EQ(sum_of({1.75 * small}), small);
    EXPECT_EQ(sum_of({-1.75 * small}), -small);
    EXPECT_EQ(sum_of({0x1p60}), large);
    EXPECT_EQ(sum_of({-0x1p60}), -large);
    EXPECT_EQ(sum_of(std::vector<double>(127, large)), 127 * large);
}

}  // namespace
}  // namespace meld
