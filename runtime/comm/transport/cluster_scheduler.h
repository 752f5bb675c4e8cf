// The scheduler of the virtual cluster: decides which of its processes runs next. Private to runtime/comm.
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

class ClusterScheduler {
  public:
    explicit ClusterScheduler(const ClusterOptions& options);

    std::uint64_t now() const { return steps_; }
    // A random number below `limit`, the same in each run with this seed. Only the process that runs may call it.
    std::uint64_t draw(std::uint64_t limit);

    // Every process calls begin() first and end() last.
    void begin(int process);
    void end(int process);
    // Lets another process run, or goes on with this one. Throws if the run has failed, or this process is killed.
    void hand_over(int process);
    // A process has got on. If none does for long, all wait for each other, which is a failure.
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
