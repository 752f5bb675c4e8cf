// Sums whose bits do not depend on the order of their terms, so that a sum is the same however its terms come together.
#pragma once

#include <algorithm>
#include <cstdint>

namespace meld {

class ExactSum {
  public:
    // What is finer than 2^-80 is cut off, what is beyond 2^40 counts as that. 127 such terms fit.
    void add(double term) {
        // In two words, for the processor has instructions for these: steps of 2^-17, and what is left over them.
        const double within = std::clamp(term, -kMost, kMost);
        const auto coarse = static_cast<std::int64_t>(within * kCoarse);
        const auto fine = static_cast<std::int64_t>((within - static_cast<double>(coarse) / kCoarse) * kFine);
        sum_ += coarse * kFineInCoarse + fine;
    }
    void add(const ExactSum& more) { sum_ += more.sum_; }
    double value() const { return static_cast<double>(sum_) / kFine; }
    bool operator==(const ExactSum&) const = default;

  private:
    __extension__ using Wide = __int128;
    static constexpr double kMost = 0x1p40, kCoarse = 0x1p17, kFine = 0x1p80;
    static constexpr Wide kFineInCoarse = Wide{1} << 63;
    Wide sum_ = 0;
};

}  // namespace meld
