// The supervisor's side of runtime/base/process/liveness.h: whether the processes of a run get on, and where they were.
#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>

#include "runtime/base/process/liveness.h"

namespace meld::comm {

class Heartbeat {
  public:
    // A run that shows no sign of life for so many seconds hangs; 0: it may take any time.
    Heartbeat(int processes, double seconds);
    ~Heartbeat();
    Heartbeat(const Heartbeat&) = delete;
    Heartbeat& operator=(const Heartbeat&) = delete;

    // Where processes find the table, for the variable liveness::kVariable.
    const std::string& place() const { return place_; }
    // The table; empty if there can be none. A place is the process with that number.
    std::span<const liveness::Place> places() const { return {table_, table_ == nullptr ? 0 : count_}; }
    // Before the processes start, also again.
    void begin();
    // To be called every second at least while they run. Time in which this process itself was stopped does not count, nor time in which
    // one of them waits for the reader of a stream. Processes that have not come to look at the table, or cannot, are not waited for.
    bool missed();

    struct Standing {
        int busy = 0;           // How many did not wait for others.
        int process = -1;       // The only one of them.
        std::int64_t tick = 0;  // The greatest of all; 0: none had begun.
        liveness::Phase phase = liveness::Phase::SetUp;
        bool stopped = false;  // By a signal, or a debugger.
    };
    Standing standing() const;
    // Process 0, which speaks for the run, has said how it ended.
    bool told() const { return table_ != nullptr && table_[0].told.load(); }

  private:
    using Clock = std::chrono::steady_clock;

    std::size_t count_;
    double seconds_;
    int file_ = -1;
    std::string place_;
    liveness::Place* table_ = nullptr;
    std::uint64_t last_beats_ = 0;
    double silent_s_ = 0;
    Clock::time_point last_look_;
};

// "in the evaluation of the program".
const char* describe(liveness::Phase phase);

}  // namespace meld::comm
