// The rates that the progress line shows.
#include <gtest/gtest.h>

#include "runtime/driver/run/report.h"

namespace meld::driver {
namespace {

sim::Summary after(std::int64_t ticks) {
    sim::Summary summary;
    summary.ticks = ticks;
    summary.derivations = static_cast<std::uint64_t>(10 * ticks);
    summary.changes = summary.messages = static_cast<std::uint64_t>(2 * ticks);
    return summary;
}

void expect(const Pace::Rates& rates, double ticks) {
    EXPECT_DOUBLE_EQ(rates.ticks, ticks);
    EXPECT_DOUBLE_EQ(rates.derivations, 10 * ticks);
    EXPECT_DOUBLE_EQ(rates.messages, 4 * ticks);
}

TEST(Pace, CountsFromWhereTheRunGoesOn) {
    Pace pace(after(1000), 50);
    expect(pace.rates(after(1000), 50), 0);
    expect(pace.rates(after(1006), 52), 3);
    expect(pace.rates(after(1012), 56), 2);
}

TEST(Pace, BeginsAgainWhereTheRunIsPutBack) {
    Pace pace(after(1000), 50);
    expect(pace.rates(after(400), 60), 0);
    expect(pace.rates(after(480), 62), 40);
}

}  // namespace
}  // namespace meld::driver
