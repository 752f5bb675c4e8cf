// Wall-clock time as this process measures it: now, and of a stage.
#pragma once

#include <chrono>

namespace meld {

// Since some moment before the process began. Never set back.
inline double seconds_now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// Adds the time of a stage to a sum: from the construction to the end of the scope.
class StageClock {
  public:
    explicit StageClock(double& seconds) : seconds_(seconds), begin_(seconds_now()) {}
    ~StageClock() { seconds_ += seconds_now() - begin_; }
    StageClock(const StageClock&) = delete;
    StageClock& operator=(const StageClock&) = delete;

  private:
    double& seconds_;
    double begin_;
};

}  // namespace meld
