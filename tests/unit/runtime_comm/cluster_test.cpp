// The virtual cluster does what every communicator does, in any order of turns, and repeats what a seed has done.
#include "runtime/comm/transport/cluster.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "runtime/comm/transport/threads.h"
#include "tests/unit/runtime_comm/semantics.h"

namespace meld::comm {
namespace {

class ClusterCase : public testing::TestWithParam<semantics::Case> {};
INSTANTIATE_TEST_SUITE_P(Semantics, ClusterCase, testing::ValuesIn(semantics::all_cases()),
                         [](const auto& instance) { return instance.param.name; });

TEST_P(ClusterCase, HoldsInAnyOrderOfTurns) {
    for (int processes = 1; processes <= 4; ++processes) {
        for (std::uint64_t seed = 0; seed < 2; ++seed) {
            SCOPED_TRACE("seed " + std::to_string(seed) + ", processes: " + std::to_string(processes));
            // Large packets in small pieces would take as many turns as pieces.
            run_cluster({.processes = processes, .seed = seed, .chunk_bytes = 1 << 16}, GetParam().run);
        }
    }
}

// Each process tells two others where it is.
void talk(Communicator& communicator) {
    const int n = communicator.processes(), me = communicator.process();
    for (int round = 0; round < 6; ++round) {
        std::vector<Packet> packets;
        for (const int to : {(me + 1) % n, (me + 2) % n})
            if (to != me) packets.push_back({to, std::vector<std::byte>(static_cast<std::size_t>(10 * round + me), std::byte(round))});
        for (const Packet& packet : communicator.exchange(std::move(packets))) {
            ASSERT_EQ(packet.bytes.size(), static_cast<std::size_t>(10 * round + packet.process));
            for (const std::byte byte : packet.bytes) ASSERT_EQ(byte, std::byte(round));
        }
        if (round % 2 == 1) communicator.barrier();
    }
}

TEST(Cluster, RepeatsWhatASeedHasDone) {
    std::set<std::uint64_t> traces;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const ClusterOptions options{.processes = 4, .seed = seed, .chunk_bytes = 16};
        const ClusterRun first = run_cluster(options, talk), second = run_cluster(options, talk);
        EXPECT_EQ(first.trace, second.trace);
        EXPECT_EQ(first.steps, second.steps);
        EXPECT_EQ(first.killed, -1);
        traces.insert(first.trace);
    }
    EXPECT_EQ(traces.size(), 20U);
}

TEST(Cluster, EndsWhereverAProcessIsKilled) {
    ClusterOptions options{.processes = 3, .seed = 5, .chunk_bytes = 16};
    const std::uint64_t steps = run_cluster(options, talk).steps;
    std::set<int> killed;
    for (options.kill_at_step = 1; options.kill_at_step <= steps; ++options.kill_at_step) {
        const ClusterRun run = run_cluster(options, talk);
        EXPECT_EQ(run.steps, options.kill_at_step);
        killed.insert(run.killed);
    }
    EXPECT_EQ(killed, (std::set<int>{0, 1, 2}));
    EXPECT_EQ(run_cluster(options, talk).killed, -1);
}

// One process may be well ahead of another, but not of what it needs from it.
TEST(Cluster, LetsProcessesRunAhead) {
    std::vector<int> done(4);
    int most = 0;
    const auto body = [&](Communicator& communicator) {
        for (int round = 0; round < 30; ++round) {
            communicator.exchange({});
            ++done[static_cast<std::size_t>(communicator.process())];
            const auto [least, greatest] = std::ranges::minmax(done);
            most = std::max(most, greatest - least);
        }
    };
    run_cluster({.processes = 4, .seed = 1}, body);
    EXPECT_EQ(most, 1);
}

TEST(Cluster, RethrowsTheFirstException) {
    const auto body = [](Communicator& communicator) {
        communicator.barrier();
        if (communicator.process() == 1) throw std::invalid_argument("process one");
        communicator.exchange({});
    };
    EXPECT_THROW(run_cluster({.processes = 3}, body), std::invalid_argument);
    EXPECT_THROW(run_cluster({.processes = 2},
                             [](Communicator& communicator) {
                                 if (communicator.process() == 1) communicator.abort(42);
                                 communicator.barrier();
                             }),
                 ProcessAborted);
}

TEST(Cluster, DifferentOperationsAtOnceAreAnErrorNotAHang) {
    EXPECT_THROW(run_cluster({.processes = 2},
                             [](Communicator& communicator) {
                                 if (communicator.process() == 0) communicator.barrier();
                                 if (communicator.process() == 1) communicator.exchange({});
                             }),
                 std::logic_error);
}

TEST(Cluster, WaitingForAProcessThatHasFinishedIsAnErrorNotAHang) {
    EXPECT_THROW(run_cluster({.processes = 3},
                             [](Communicator& communicator) {
                                 if (communicator.process() != 0) communicator.barrier();
                             }),
                 std::logic_error);
}

}  // namespace
}  // namespace meld::comm
