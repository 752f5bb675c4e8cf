// Whose turn it is in the virtual cluster. Private to runtime/comm.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <string>
#include <vector>

#include "runtime/comm/transport/cluster.h"

namespace meld::comm {

// Thrown in the process that is killed.
struct ProcessKilled {};

class Turns {
  public:
    explicit Turns(const ClusterOptions& options);

    std::uint64_t now() const { return steps_; }
    // Below `limit`, and the same in each run with this seed. Only in one's turn.
    std::uint64_t draw(std::uint64_t limit);

    // The rest of a process's life lies between these.
    void begin(int process);
    void end(int process);
    // Hands over to another process, or goes on. Throws if the run has failed, or this process is killed.
    void hand_over(int process);
    // Something has moved, so that the processes do not wait for each other for ever.
    void note_progress() { idle_steps_ = 0; }

    void fail(std::exception_ptr failure);
    // Ends the run with a std::logic_error.
    [[noreturn]] void break_with(const std::string& what);
    // Rethrows what failed, if anything but a kill.
    ClusterRun outcome() const;

  private:
    int next();
    void wait_for_turn(std::unique_lock<std::mutex>& lock, int process);

    const ClusterOptions options_;
    std::mutex mutex_;
    std::vector<std::condition_variable> woken_;  // By process.
    std::vector<bool> there_;
    int turn_ = 0;
    std::uint64_t steps_ = 0, draws_ = 0, idle_steps_ = 0, trace_ = 0;
    int killed_ = -1;
    bool failed_ = false;
    std::exception_ptr failure_;
};

}  // namespace meld::comm
