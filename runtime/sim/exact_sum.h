// Sums whose bits do not depend on the order of their terms, so that a catom's sum is the same however the terms come together.
#pragma once

#include <algorithm>

namespace meld::sim {

class ExactSum {
  public:
    // What is finer than 2^-80 is cut off, what is beyond 2^40 counts as that. 127 such terms fit.
    void add(double term) { sum_ += static_cast<Wide>(std::clamp(term, -kMost, kMost) * kScale); }
    double value() const { return static_cast<double>(sum_) / kScale; }

  private:
    __extension__ using Wide = __int128;
    static constexpr double kMost = 0x1p40, kScale = 0x1p80;
    Wide sum_ = 0;
};

}  // namespace meld::sim
