#include "runtime/world/partition/balance_rule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

namespace meld::partition {
namespace {

constexpr std::uint64_t kBricks = 64;

// Sixty-four full bricks along the curve, and their work in a window.
std::vector<BrickWork> bricks(const std::function<std::uint64_t(std::uint64_t)>& work) {
    std::vector<BrickWork> all;
    for (std::uint64_t key = 0; key < kBricks; ++key) all.push_back({key, work(key), kBrickCells});
    return all;
}

Partition divided_by_catoms(int processes) {
    std::vector<std::pair<BrickKey, std::uint32_t>> counts;
    for (std::uint64_t key = 0; key < kBricks; ++key) counts.emplace_back(key, kBrickCells);
    return {counts, processes};
}

std::vector<std::uint64_t> work_of(const std::vector<BrickWork>& bricks, const Partition& partition) {
    std::vector<std::uint64_t> work(static_cast<std::size_t>(partition.processes()));
    for (const BrickWork& brick : bricks) work[static_cast<std::size_t>(partition.owner(brick.key))] += brick.work;
    return work;
}

// A run of so many windows; what all have waited for the busiest process, and what divisions have cost.
struct Course {
    std::uint64_t waited = 0, paid = 0;
};
Course course(BalanceRule& rule, Partition partition, int windows, const std::function<std::vector<BrickWork>(int)>& of) {
    Course course;
    for (int window = 0; window < windows; ++window) {
        const std::vector<BrickWork> now = of(window);
        const std::vector<std::uint64_t> work = work_of(now, partition);
        std::uint64_t all = 0;
        for (const std::uint64_t w : work) all += w;
        course.waited += std::ranges::max(work) - all / work.size();
        rule.end_window(work);
        if (!rule.looks()) continue;
        const auto next = rule.divide(now, partition, window);
        if (!next) continue;
        course.paid += BalanceRule::kCostOfMove * BalanceRule::most_moved(now, partition, *next);
        partition = *next;
    }
    return course;
}

TEST(BalanceRule, LeavesEvenWorkAlone) {
    BalanceRule rule(false);
    course(rule, divided_by_catoms(4), 100, [](int) { return bricks([](std::uint64_t) { return 4096; }); });
    EXPECT_TRUE(rule.divisions().empty());
    EXPECT_EQ(rule.imbalance(), 1);
}

TEST(BalanceRule, LeavesALittleWorkAlone) {
    BalanceRule rule(false);
    course(rule, divided_by_catoms(4), 100, [](int) { return bricks([](std::uint64_t key) { return key == 0 ? 10U : 0U; }); });
    EXPECT_TRUE(rule.divisions().empty());
}

TEST(BalanceRule, DividesOnceWhereWorkStays) {
    BalanceRule rule(false);
    const auto corner = bricks([](std::uint64_t key) { return key < 8 ? 4096U : 0U; });
    course(rule, divided_by_catoms(2), 200, [&](int) { return corner; });
    ASSERT_EQ(rule.divisions().size(), 1U);
    EXPECT_EQ(rule.divisions()[0].imbalance, 2);
    EXPECT_LT(rule.imbalance(), 1.05);
}

TEST(BalanceRule, WaitsUntilItIsWorthTheMove) {
    BalanceRule rule(false);
    const auto corner = bricks([](std::uint64_t key) { return key < 8 ? 4096U : 0U; });
    // Half of what the first process does is lost in each window, and half of the catoms move.
    const std::uint64_t lost = 8 * 4096 / 2, cost = BalanceRule::kCostOfMove * (kBricks / 2 - 4) * kBrickCells;
    course(rule, divided_by_catoms(2), 1000, [&](int) { return corner; });
    ASSERT_EQ(rule.divisions().size(), 1U);
    EXPECT_EQ(rule.divisions()[0].tick, static_cast<std::int64_t>((cost + lost - 1) / lost) - 1);
}

TEST(BalanceRule, NeverPaysMuchMoreThanIsWaited) {
    for (const int stay : {1, 3, 10, 40}) {
        BalanceRule rule(false);
        const Course all = course(rule, divided_by_catoms(4), 400, [&](int window) {
            const auto place = static_cast<std::uint64_t>(window / stay * 13) % kBricks;
            return bricks([&](std::uint64_t key) { return (key + kBricks - place) % kBricks < 8 ? 4096U : 0U; });
        });
        EXPECT_LE(all.paid, all.waited) << stay;
    }
}

TEST(BalanceRule, LimitsTheCatomsOfAProcess) {
    BalanceRule rule(true);
    const auto corner = bricks([](std::uint64_t key) { return key == 0 ? 4096U : 0U; });
    const auto next = rule.divide(corner, divided_by_catoms(16), 1);
    ASSERT_TRUE(next.has_value());
    std::vector<std::uint64_t> catoms(16);
    for (const BrickWork& brick : corner) catoms[static_cast<std::size_t>(next->owner(brick.key))] += brick.catoms;
    EXPECT_LE(std::ranges::max(catoms), 3 * kBricks / 16 * kBrickCells + kBrickCells);
}

}  // namespace
}  // namespace meld::partition
