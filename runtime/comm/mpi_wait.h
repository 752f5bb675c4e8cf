// Waiting for others without occupying the core they may need: there can be more processes than cores, or other work.
#pragma once

#include <mpi.h>

#include <chrono>
#include <thread>

#include "runtime/base/pulse.h"
#include "runtime/comm/peers.h"

namespace meld::comm {

// Polls continuously while an answer is likely soon, then yields the core. With more processes than cores hardly any answer comes soon:
// three processes on two cores took 14 milliseconds a tick of five exchanges when they polled, and 0.6 when they sleep at once.
class Backoff {
  public:
    Backoff() = default;
    ~Backoff() { reset(); }
    Backoff(const Backoff&) = delete;
    Backoff& operator=(const Backoff&) = delete;
    void reset() {
        if (idle_polls_ > hard_polls) pulse::wait(false);
        idle_polls_ = 0;
    }
    void wait() {
        if (++idle_polls_ <= hard_polls) return;
        if (idle_polls_ == hard_polls + 1) pulse::wait(true);
        std::this_thread::sleep_for(kNap);
        if (idle_polls_ % kPollsPerLook == 0 && peers != nullptr) peers->look();
    }
    // Set once, before the first exchange.
    static void expect_crowd() { hard_polls = 20; }
    // Called from time to time in a long wait; nullptr: nothing is called.
    static void set_peers(Peers* looked_at) { peers = looked_at; }

  private:
    static inline int hard_polls = 4000;  // About a millisecond.
    static inline Peers* peers = nullptr;
    static constexpr auto kNap = std::chrono::microseconds(20);
    static constexpr int kPollsPerLook = 1024;  // About a tenth of a second.
    int idle_polls_ = 0;
};

inline void wait_patiently(MPI_Request& request) {
    Backoff backoff;
    for (int complete = 0;;) {
        MPI_Test(&request, &complete, MPI_STATUS_IGNORE);
        if (complete != 0) return;
        backoff.wait();
    }
}

}  // namespace meld::comm
