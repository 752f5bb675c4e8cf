// Sums whose bits do not depend on the order or grouping of their terms.
#pragma once

#include <algorithm>
#include <cstdint>

namespace meld {

class ExactSum {
  public:
    // Parts finer than 2^-80 are cut off, and terms beyond 2^40 count as that. 127 such terms fit.
    void add(double term) {
        // In two words, because processors have instructions for these: multiples of 2^-17, and the remainder.
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
