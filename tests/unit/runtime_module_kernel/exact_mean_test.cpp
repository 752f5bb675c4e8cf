// The mean of doubles against values worked out by hand and against arithmetic in 113 bits.
#include "runtime/module/kernel/exact_mean.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace meld {
namespace {

double mean_of(const std::vector<double>& values) {
    ExactMean mean;
    for (const double v : values) mean.add(v);
    return mean.of(static_cast<u32>(values.size()));
}

constexpr double kLargest = std::numeric_limits<double>::max(), kSmallest = std::numeric_limits<double>::denorm_min(),
                 kNormal = std::numeric_limits<double>::min();

TEST(ExactMean, OfOneValueIsThatValue) {
    for (const double v : {0.0, 1.0, -1.0, 0.1, -3.75, 1e300, -1e-300, kLargest, -kLargest, kSmallest, -kSmallest, kNormal})
        EXPECT_EQ(mean_of({v}), v);
}

TEST(ExactMean, LosesNothingBetweenLargeAndSmall) {
    EXPECT_EQ(mean_of({1e300, 1.0, -1e300, 2.0}), 0.75);
    EXPECT_EQ(mean_of({kLargest, kLargest, kLargest}), kLargest);
    EXPECT_EQ(mean_of({kLargest, -kLargest, kSmallest, kSmallest, kSmallest, kSmallest}), kSmallest);
    EXPECT_EQ(mean_of({-kLargest, kLargest, -6.0}), -2.0);
}

TEST(ExactMean, RoundsOnceAndTiesToEven) {
    EXPECT_EQ(mean_of({1.0, std::nextafter(1.0, 2.0)}), 1.0);
    EXPECT_EQ(mean_of({std::nextafter(1.0, 2.0), std::nextafter(std::nextafter(1.0, 2.0), 2.0)}), 1.0 + 0x1p-51);
    // Half of the smallest double is a tie between it and zero; a little more than half is not.
    EXPECT_EQ(mean_of({kSmallest, 0.0}), 0.0);
    EXPECT_EQ(mean_of({kSmallest, kSmallest, 0.0}), kSmallest);
    EXPECT_EQ(mean_of({3 * kSmallest, 0.0}), 2 * kSmallest);
    // From below the normal numbers up into them.
    EXPECT_EQ(mean_of({kNormal - kSmallest, kNormal}), kNormal);
}

TEST(ExactMean, OfZeroHasNoSign) {
    EXPECT_FALSE(std::signbit(mean_of({-0.0})));
    EXPECT_FALSE(std::signbit(mean_of({1.5, -1.5})));
    EXPECT_FALSE(std::signbit(mean_of({-kSmallest, 0.0, 0.0})));
}

TEST(ExactMean, AgreesWithWiderArithmeticInAnyOrder) {
    std::mt19937_64 random(7);
    for (int trial = 0; trial < 20'000; ++trial) {
        std::vector<double> values(1 + random() % 9);
        __extension__ __float128 sum = 0;
        for (double& v : values) {
            v = std::ldexp(static_cast<double>(static_cast<std::int64_t>(random())), static_cast<int>(random() % 24) - 60);
            sum += v;
        }
        const double expected = static_cast<double>(sum / static_cast<double>(values.size()));
        EXPECT_EQ(mean_of(values), expected);
        std::shuffle(values.begin(), values.end(), random);
        EXPECT_EQ(mean_of(values), expected);
    }
}

}  // namespace
}  // namespace meld
