// Numbers of runs, summed up.
#pragma once

#include <optional>
#include <vector>

#include "runtime/driver/study/study_table.h"

namespace meld::driver {

struct Quartiles {
    double low = 0, median = 0, high = 0;
};

// Interpolated between neighbours, as most programs do (type 7 of Hyndman and Fan, 1996). Of no values zeros.
Quartiles quartiles(std::vector<double> values);
// The part `p` of the values, from 0 to 1, that lies below; they are sorted, and there is at least one.
double quantile(const std::vector<double>& sorted, double p);

// Nothing: it is no number.
std::optional<double> number_of(const StudyCell& cell);

}  // namespace meld::driver
