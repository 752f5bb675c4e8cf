#include "runtime/base/process/tick_log.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>

#include "runtime/base/process/parallel_for.h"
#include "runtime/base/process/stage_clock.h"

namespace meld {
namespace {

TEST(TickLog, CoversAllTicksOfALongRunInBoundedSpace) {
    TickLog log(2);
    constexpr std::int64_t kTicks = 10'001;
    for (std::int64_t tick = 1; tick <= kTicks; ++tick) {
        log.begin_tick(tick);
        log.enter(TickLog::Stage::Evaluation);
        log.add_busy(1, 0.5);
        log.enter(TickLog::Stage::Exchange);
    }
    log.end();
    ASSERT_LE(log.spans().size(), 4096U);
    std::int64_t next = 1;
    double busy = 0, seconds = 0;
    for (const TickLog::Span& span : log.spans()) {
        EXPECT_EQ(span.first, next);
        next = span.last + 1;
        EXPECT_EQ(span.busy.at(0), 0);
        busy += span.busy.at(1);
        seconds += std::accumulate(span.seconds.begin(), span.seconds.end(), 0.0);
    }
    EXPECT_EQ(next, kTicks + 1);
    EXPECT_EQ(busy, 0.5 * kTicks);
    EXPECT_GT(seconds, 0);
}

TEST(TickLog, GivesTheTimeToTheStageThatItPassedIn) {
    TickLog log(1);
    log.begin_tick(7);
    log.enter(TickLog::Stage::Motion);
    const double begin = seconds_now();
    while (seconds_now() < begin + 0.002) {
    }
    log.enter(TickLog::Stage::Recording);
    log.end();
    ASSERT_EQ(log.spans().size(), 1U);
    EXPECT_EQ(log.spans()[0].first, 7);
    EXPECT_GE(log.spans()[0].seconds[static_cast<std::size_t>(TickLog::Stage::Motion)], 0.002);
    EXPECT_EQ(log.spans()[0].seconds[static_cast<std::size_t>(TickLog::Stage::Exchange)], 0);
}

TEST(Periodic, CallsUntilItIsDestroyed) {
    std::atomic<int> calls = 0;
    {
        const Periodic often(std::chrono::microseconds(100), [&] { ++calls; });
        while (calls < 3) {
        }
    }
    const int at_the_end = calls;
    const double begin = seconds_now();
    while (seconds_now() < begin + 0.002) {
    }
    EXPECT_EQ(calls, at_the_end);
}

}  // namespace
}  // namespace meld
