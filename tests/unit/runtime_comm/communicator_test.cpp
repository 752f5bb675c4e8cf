// The semantic cases over one process and over threads, and what threads do when one of them fails.
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

#include "runtime/comm/transport/communicator.h"
#include "runtime/comm/transport/threads.h"
#include "tests/unit/runtime_comm/semantics.h"

namespace meld::comm {
namespace {

class CommunicatorCase : public testing::TestWithParam<semantics::Case> {};
INSTANTIATE_TEST_SUITE_P(Semantics, CommunicatorCase, testing::ValuesIn(semantics::all_cases()),
                         [](const auto& instance) { return instance.param.name; });

TEST_P(CommunicatorCase, HoldsForOneProcessAlone) { GetParam().run(*make_single()); }

TEST_P(CommunicatorCase, HoldsForThreads) {
    for (int processes = 1; processes <= 4; ++processes) run_threads_as_processes(processes, GetParam().run);
}

TEST(ThreadsAsProcesses, RethrowTheFirstExceptionAndFreeTheOthers) {
    std::atomic<int> freed{0};
    const auto body = [&](Communicator& communicator) {
        communicator.barrier();
        if (communicator.process() == 1) throw std::invalid_argument("process one");
        try {
            communicator.exchange({});
            communicator.exchange({});
        } catch (const OtherProcessFailed&) {
            ++freed;
            throw;
        }
    };
    EXPECT_THROW(run_threads_as_processes(4, body), std::invalid_argument);
    EXPECT_EQ(freed.load(), 3);
}

TEST(ThreadsAsProcesses, AbortEndsAllWithItsExitCode) {
    try {
        run_threads_as_processes(3, [](Communicator& communicator) {
            if (communicator.process() == 2) communicator.abort(42);
            communicator.allgather({});
        });
        FAIL() << "nothing was thrown";
    } catch (const ProcessAborted& aborted) {
        EXPECT_EQ(aborted.exit_code(), 42);
    }
}

TEST(ThreadsAsProcesses, DifferentOperationsAtOnceAreAnErrorNotAHang) {
    EXPECT_THROW(run_threads_as_processes(2,
                                          [](Communicator& communicator) {
                                              if (communicator.process() == 0) communicator.barrier();
                                              if (communicator.process() == 1) communicator.exchange({});
                                          }),
                 std::logic_error);
}

TEST(ThreadsAsProcesses, WaitingForAProcessThatHasFinishedIsAnErrorNotAHang) {
    EXPECT_THROW(run_threads_as_processes(3,
                                          [](Communicator& communicator) {
                                              if (communicator.process() != 0) communicator.barrier();
                                          }),
                 std::logic_error);
}

TEST(CommunicatorDeathTest, RefusesPacketsToNobody) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    EXPECT_EXIT(make_single()->exchange({Packet{0, {}}}), testing::ExitedWithCode(70), "to process 0");
    EXPECT_EXIT(make_single()->abort(9), testing::ExitedWithCode(9), "");
}

}  // namespace
}  // namespace meld::comm
