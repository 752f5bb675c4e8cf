// What a part that is a thread may meet: the failures of the other parts.
#pragma once

#include <stdexcept>

namespace meld::comm {

// Thrown in every part that waits for, or next calls, the others after one of them has failed.
struct OtherPartFailed : std::runtime_error {
    OtherPartFailed() : std::runtime_error("another part has failed") {}
};

// Thrown by abort() where parts are threads; run_threads_as_parts rethrows it.
class PartAborted : public std::runtime_error {
  public:
    explicit PartAborted(int exit_code) : std::runtime_error("a part has aborted the run"), exit_code_(exit_code) {}
    int exit_code() const { return exit_code_; }

  private:
    int exit_code_;
};

}  // namespace meld::comm
