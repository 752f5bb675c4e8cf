#include "physics/statics/point_shares.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace meld::physics {

namespace {

constexpr std::size_t kMost = kMaxManifoldPoints;

// Of the points in a set (bits): the shares of 1, of any sign, whose mean of arms is nearest to 0, and of several such the most even
// ones. Of a matrix G of the products of arms, and a little on its diagonal, these are G^-1 1 over its sum, and 1 over that sum is what is
// minimized.
struct Shared {
    PointShares shares{};
    double cost = 0;
};
Shared share_among(unsigned set, std::span<const Vec3> arms, double evenness) {
    std::array<std::size_t, kMost> of{};
    std::size_t count = 0;
    for (std::size_t p = 0; p < arms.size(); ++p)
        if ((set >> p & 1u) != 0) of[count++] = p;
    std::array<std::array<double, kMost + 1>, kMost> rows{};
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < count; ++j) rows[i][j] = dot(arms[of[i]], arms[of[j]]) + (i == j ? evenness : 0);
        rows[i][kMost] = 1;
    }
    // Positive definite, so elimination needs no pivots.
    for (std::size_t k = 0; k < count; ++k)
        for (std::size_t i = k + 1; i < count; ++i) {
            const double factor = rows[i][k] / rows[k][k];
            for (std::size_t j = k; j < count; ++j) rows[i][j] -= factor * rows[k][j];
            rows[i][kMost] -= factor * rows[k][kMost];
        }
    Shared found;
    double sum = 0;
    for (std::size_t i = count; i-- > 0;) {
        double value = rows[i][kMost];
        for (std::size_t j = i + 1; j < count; ++j) value -= rows[i][j] * found.shares[of[j]];
        sum += found.shares[of[i]] = value / rows[i][i];
    }
    for (double& share : found.shares) share /= sum;
    found.cost = 1 / sum;
    return found;
}

}  // namespace

PointShares shares_of(std::span<const Vec3> arms) {
    constexpr double kEvenness = 1e-7;
    double farthest = 0;
    for (const Vec3 arm : arms) farthest = std::max(farthest, dot(arm, arm));
    if (arms.size() == 1 || farthest == 0) {
        PointShares alike{};
        std::fill_n(alike.begin(), arms.size(), 1.0 / static_cast<double>(arms.size()));
        return alike;
    }
    Shared best{{}, std::numeric_limits<double>::infinity()};
    for (unsigned set = 1; set < 1u << arms.size(); ++set) {
        const Shared found = share_among(set, arms, kEvenness * farthest);
        if (found.cost < best.cost && std::ranges::all_of(found.shares, [](double share) { return share >= 0; })) best = found;
    }
    return best.shares;
}

}  // namespace meld::physics
