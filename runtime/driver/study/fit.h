// What numbers of many runs say: a power law through points, and whether two variants differ.
#pragma once

#include <optional>
#include <utility>
#include <vector>

namespace meld::driver {

// y = factor * x^exponent, by least squares of the logarithms.
struct PowerFit {
    double exponent = 0, low = 0, high = 0;  // With its interval of 95% confidence.
    double factor = 0;
};

// Nothing: some number is not above zero, or there are not three points with two different x.
std::optional<PowerFit> fit_power(const std::vector<std::pair<double, double>>& points);

// The bound that a value of Student's t distribution is below with this probability, above a half.
double student_quantile(double probability, double degrees_of_freedom);

// The two-sided probability that paired numbers differ so much by chance: Wilcoxon's signed-rank test, without pairs of equal numbers, with
// mean ranks for ties; exact for at most kExactPairs pairs, otherwise by the normal distribution. Without any difference 1.
inline constexpr std::size_t kExactPairs = 200;
double signed_rank_test(const std::vector<double>& differences);

}  // namespace meld::driver
