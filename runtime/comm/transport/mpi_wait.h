// Waiting for others without occupying the core they may need: there can be more processes than cores, or other work.
#pragma once

#include <mpi.h>

#include <chrono>
#include <limits>
#include <thread>

#include "runtime/base/process/liveness.h"
#include "runtime/comm/transport/stragglers.h"

namespace meld::comm {

// Polls continuously while an answer is likely soon, then naps. With more processes than cores hardly any answer comes soon: three
// processes on two cores took 14 milliseconds a tick of five exchanges when they polled, and 0.6 when they nap at once. If other programs
// want the core, a poll that yields it takes as long as their time slices, so it is the time that counts and not the number of polls.
class Backoff {
  public:
    Backoff() = default;
    ~Backoff() { reset(); }
    Backoff(const Backoff&) = delete;
    Backoff& operator=(const Backoff&) = delete;
    void reset() {
        if (naps_ > 0) liveness::wait(false);
        polls_ = naps_ = 0;
    }
    void wait() {
        if (naps_ == 0) {
            const Clock::time_point now = Clock::now();
            if (polls_++ == 0) first_ = now;
            if (polls_ <= hard_polls && now - first_ < kHardTime) return;
            liveness::wait(true);
        }
        std::this_thread::sleep_for(kNap);
        if (++naps_ % kNapsPerLook == 0 && stragglers != nullptr) stragglers->look();
    }
    // Set once, before the first exchange.
    static void expect_crowd() { hard_polls = 20; }
    // Called from time to time in a long wait; nullptr: nothing is called.
    static void set_stragglers(Stragglers* of_run) { stragglers = of_run; }

  private:
    using Clock = std::chrono::steady_clock;
    static inline int hard_polls = std::numeric_limits<int>::max();
    static inline Stragglers* stragglers = nullptr;
    static constexpr auto kHardTime = std::chrono::milliseconds(1);
    static constexpr auto kNap = std::chrono::microseconds(20);
    static constexpr int kNapsPerLook = 1024;  // About a tenth of a second.
    Clock::time_point first_;
    int polls_ = 0, naps_ = 0;
};

inline void wait_with_backoff(MPI_Request& request) {
    Backoff backoff;
    for (int complete = 0;;) {
        MPI_Test(&request, &complete, MPI_STATUS_IGNORE);
        if (complete != 0) return;
        backoff.wait();
    }
}

}  // namespace meld::comm
