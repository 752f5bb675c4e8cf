// The failures of other processes that a process may see if it is a thread.
#pragma once

#include <stdexcept>

namespace meld::comm {

// Thrown in every process that waits for the others, or next calls them, after one of them has failed.
struct OtherProcessFailed : std::runtime_error {
    OtherProcessFailed() : std::runtime_error("another process has failed") {}
};

// Thrown by abort() where processes are threads; run_threads_as_processes rethrows it.
class ProcessAborted : public std::runtime_error {
  public:
    explicit ProcessAborted(int exit_code) : std::runtime_error("a process has aborted the run"), exit_code_(exit_code) {}
    int exit_code() const { return exit_code_; }

  private:
    int exit_code_;
};

}  // namespace meld::comm
