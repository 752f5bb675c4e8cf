#include "runtime/driver/study/fit.h"

#include <algorithm>
#include <cmath>

namespace meld::driver {

namespace {

// Of Student's t distribution, from 0 to t, by Simpson's rule.
double student_half(double t, double degrees) {
    constexpr int kSteps = 2000;
    const double scale = std::exp(std::lgamma((degrees + 1) / 2) - std::lgamma(degrees / 2)) / std::sqrt(degrees * M_PI);
    const auto density = [&](double x) { return scale * std::pow(1 + x * x / degrees, -(degrees + 1) / 2); };
    double sum = density(0) + density(t);
    for (int i = 1; i < kSteps; ++i) sum += density(t * i / kSteps) * (i % 2 == 1 ? 4 : 2);
    return sum * t / kSteps / 3;
}

}  // namespace

double student_quantile(double probability, double degrees_of_freedom) {
    double low = 0, high = 1;
    while (0.5 + student_half(high, degrees_of_freedom) < probability && high < 1e6) high *= 2;
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (0.5 + student_half(middle, degrees_of_freedom) < probability ? low : high) = middle;
    }
    return (low + high) / 2;
}

std::optional<PowerFit> fit_power(const std::vector<std::pair<double, double>>& points) {
    if (points.size() < 3) return std::nullopt;
    const auto n = static_cast<double>(points.size());
    double mean_x = 0, mean_y = 0;
    for (const auto& [x, y] : points) {
        if (x <= 0 || y <= 0) return std::nullopt;
        mean_x += std::log(x) / n;
        mean_y += std::log(y) / n;
    }
    double xx = 0, xy = 0;
    for (const auto& [x, y] : points) {
        xx += (std::log(x) - mean_x) * (std::log(x) - mean_x);
        xy += (std::log(x) - mean_x) * (std::log(y) - mean_y);
    }
    if (xx < 1e-12) return std::nullopt;
    const double exponent = xy / xx;
    double rest = 0;
    for (const auto& [x, y] : points) {
        const double error = std::log(y) - mean_y - exponent * (std::log(x) - mean_x);
        rest += error * error;
    }
    const double half = student_quantile(0.975, n - 2) * std::sqrt(rest / (n - 2) / xx);
    return PowerFit{exponent, exponent - half, exponent + half, std::exp(mean_y - exponent * mean_x)};
}

double signed_rank_test(const std::vector<double>& differences) {
    std::vector<double> all;
    for (const double d : differences)
        if (d != 0) all.push_back(d);
    if (all.empty()) return 1;
    std::ranges::sort(all, [](double a, double b) { return std::abs(a) < std::abs(b); });
    const std::size_t n = all.size();
    // Twice the ranks, which are whole numbers also where ties share them.
    std::vector<std::size_t> ranks(n);
    for (std::size_t i = 0; i < n;) {
        std::size_t end = i;
        while (end < n && std::abs(all[end]) == std::abs(all[i])) ++end;
        for (std::size_t k = i; k < end; ++k) ranks[k] = i + 1 + end;
        i = end;
    }
    std::size_t total = 0, positive = 0;
    for (std::size_t i = 0; i < n; ++i) {
        total += ranks[i];
        if (all[i] > 0) positive += ranks[i];
    }
    const std::size_t least = std::min(positive, total - positive);
    if (n > kExactPairs) {
        double squares = 0;
        for (const std::size_t rank : ranks) squares += static_cast<double>(rank) * static_cast<double>(rank);
        const double z = (static_cast<double>(least) - static_cast<double>(total) / 2) / std::sqrt(squares / 4);
        return std::erfc(-z / std::sqrt(2.0));
    }
    // The part of all ways to choose signs in which the positive ranks have this sum.
    std::vector<double> part(total + 1);
    part[0] = 1;
    std::size_t reached = 0;
    for (const std::size_t rank : ranks) {
        reached += rank;
        for (std::size_t sum = reached + 1; sum-- > 0;) part[sum] = (part[sum] + (sum >= rank ? part[sum - rank] : 0)) / 2;
    }
    double below = 0;
    for (std::size_t sum = 0; sum <= least; ++sum) below += part[sum];
    return std::min(1.0, 2 * below);
}

}  // namespace meld::driver
