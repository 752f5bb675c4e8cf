// Adds the wall-clock time of a stage to a sum: from the construction to the end of the scope.
#pragma once

#include <chrono>

namespace meld {

class StageClock {
  public:
    explicit StageClock(double& seconds) : seconds_(seconds), begin_(Clock::now()) {}
    ~StageClock() { seconds_ += std::chrono::duration<double>(Clock::now() - begin_).count(); }
    StageClock(const StageClock&) = delete;
    StageClock& operator=(const StageClock&) = delete;

  private:
    using Clock = std::chrono::steady_clock;
    double& seconds_;
    Clock::time_point begin_;
};

}  // namespace meld
