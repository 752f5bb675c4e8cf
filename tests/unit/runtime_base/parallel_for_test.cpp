#include "runtime/base/process/parallel_for.h"

#include <gtest/gtest.h>
#include <atomic>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace meld {
namespace {

class WorkersOf : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Threads, WorkersOf, testing::Values(1, 2, 3, 8));

TEST_P(WorkersOf, VisitEachIndexOnce) {
    Workers workers(GetParam());
    EXPECT_EQ(workers.threads(), GetParam());
    for (std::size_t count : {0u, 1u, 2u, 7u, 1000u}) {
        std::vector<int> visits(count, 0);
        workers.run(count, [&](int, std::size_t index) { ++visits[index]; });
        EXPECT_EQ(visits, std::vector<int>(count, 1));
    }
}

TEST_P(WorkersOf, NumberTheirThreadsFromZero) {
    Workers workers(GetParam());
    std::vector<std::uint64_t> sums(static_cast<std::size_t>(GetParam()), 0);
    workers.run(10000, [&](int worker, std::size_t index) { sums.at(static_cast<std::size_t>(worker)) += index; });
    EXPECT_EQ(std::accumulate(sums.begin(), sums.end(), std::uint64_t{0}), 49995000u);
}

TEST_P(WorkersOf, SeeWhatTheCallerWroteBetweenManyShortJobs) {
    Workers workers(GetParam());
    std::vector<std::uint64_t> values(16, 0);
    for (std::uint64_t job = 0; job < 3000; ++job) {
        workers.run(values.size(), [&](int, std::size_t index) { values[index] += job; });
        const std::uint64_t expected = job * (job + 1) / 2;
        ASSERT_EQ(values, std::vector<std::uint64_t>(16, expected));
    }
}

TEST_P(WorkersOf, RethrowTheExceptionOfABodyAndGoOn) {
    Workers workers(GetParam());
    const auto fails = [](int, std::size_t index) {
        if (index == 5) throw std::runtime_error("five");
    };
    EXPECT_THROW(workers.run(100, fails), std::runtime_error);
    std::atomic<int> visits{0};
    workers.run(100, [&](int, std::size_t) { ++visits; });
    EXPECT_EQ(visits.load(), 100);
}

TEST(Workers, OneThreadGoesInOrder) {
    Workers workers(1);
    std::vector<std::size_t> order;
    workers.run(5, [&](int, std::size_t index) { order.push_back(index); });
    EXPECT_EQ(order, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
}

TEST(Workers, AsManyIndicesAsThreadsRunAtOnce) {
    Workers workers(4);
    std::atomic<int> inside{0};
    workers.run(4, [&](int, std::size_t) {
        ++inside;
        while (inside.load() < 4) std::atomic_signal_fence(std::memory_order_seq_cst);
    });
    EXPECT_EQ(inside.load(), 4);
}

TEST(Workers, ComeAndGoWithoutAJob) {
    for (int i = 0; i < 50; ++i) Workers workers(3);
}

TEST(WorkersDeathTest, RefuseAJobWithinAJob) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    EXPECT_EXIT(
        {
            Workers workers(1);
            workers.run(1, [&](int, std::size_t) { workers.run(1, [](int, std::size_t) {}); });
        },
        testing::ExitedWithCode(70), "another one of the same workers");
}

}  // namespace
}  // namespace meld
