#include "physics/statics/point_shares.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "physics/bodies/symmetric.h"
#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

// What is minimized is the square of the mean of the arms, plus `evenness` times the sum of the squares of the shares. Some shares are
// free, the others 0.
struct Sharing {
    std::span<const Vec3> arms;
    std::span<double> shares;
    double evenness = 0;
    std::vector<char> free = {};
    // The best shares, of any sign, with those that are free.
    std::vector<double> best = {};

    void solve();
    std::size_t most_missing() const;
    std::size_t approach();
};

// Elimination: positive definite, so it needs no pivots, but may be so nearly singular that cofactors would be rounding alone.
Vec3 solved(const Symmetric& m, Vec3 right) {
    const double xy = m.xy / m.xx, xz = m.xz / m.xx;
    const double yy = m.yy - xy * m.xy, yz = m.yz - xy * m.xz, z_of_y = yz / yy;
    const double zz = m.zz - xz * m.xz - z_of_y * yz;
    const double y = right.y - xy * right.x, z = (right.z - xz * right.x - z_of_y * y) / zz;
    const double solved_y = y / yy - z_of_y * z;
    return {right.x / m.xx - xy * solved_y - xz * z, solved_y, z};
}

// In proportion to 1 - a . r, where (evenness + sum of a a^T) r is the sum of the free points' arms a.
void Sharing::solve() {
    Symmetric squares{evenness, 0, 0, evenness, 0, evenness};
    Vec3 sum;
    for (std::size_t i = 0; i < arms.size(); ++i) {
        if (free[i] == 0) continue;
        const Vec3 a = arms[i];
        squares += {a.x * a.x, a.x * a.y, a.x * a.z, a.y * a.y, a.y * a.z, a.z * a.z};
        sum = sum + a;
    }
    const Vec3 r = solved(squares, sum);
    double all = 0;
    for (std::size_t i = 0; i < arms.size(); ++i) all += best[i] = free[i] == 0 ? 0 : 1 - dot(arms[i], r);
    for (double& share : best) share /= all;
}

// Of the points that are not free, that by which a share would lessen most what is minimized; how many there are if by none.
std::size_t Sharing::most_missing() const {
    // Of the gradient, as a share of the evenness: what is less is rounding.
    constexpr double kLeast = 1e-2;
    Vec3 mean;
    for (std::size_t i = 0; i < arms.size(); ++i) mean = mean + shares[i] * arms[i];
    const auto gradient = [&](std::size_t i) { return dot(arms[i], mean) + evenness * shares[i]; };
    double least = -kLeast * evenness;
    for (std::size_t i = 0; i < arms.size(); ++i) least += shares[i] * gradient(i);
    std::size_t found = arms.size();
    for (std::size_t i = 0; i < arms.size(); ++i)
        if (free[i] == 0 && gradient(i) < least) found = i, least = gradient(i);
    return found;
}

// Goes from the shares towards the best ones until one is 0, which is free no more. Returns its number; how many there are if none was.
std::size_t Sharing::approach() {
    std::size_t first = arms.size();
    double way = 1;
    for (std::size_t i = 0; i < arms.size(); ++i)
        if (free[i] != 0 && best[i] < 0)
            if (const double here = shares[i] / (shares[i] - best[i]); here < way) first = i, way = here;
    for (std::size_t i = 0; i < arms.size(); ++i) shares[i] = std::max(0.0, shares[i] + way * (best[i] - shares[i]));
    if (first < arms.size()) shares[first] = 0, free[first] = 0;
    return first;
}

}  // namespace

void shares_of(std::span<const Vec3> arms, std::span<double> shares) {
    MELD_EXPECT(!arms.empty() && shares.size() == arms.size(), "{} arms, {} shares", arms.size(), shares.size());
    constexpr double kEvenness = 1e-7;
    double farthest = 0;
    for (const Vec3 arm : arms) farthest = std::max(farthest, dot(arm, arm));
    if (arms.size() == 1 || farthest == 0) {
        std::ranges::fill(shares, 1.0 / static_cast<double>(arms.size()));
        return;
    }
    thread_local Sharing sharing;
    sharing.arms = arms, sharing.shares = shares, sharing.evenness = kEvenness * farthest;
    sharing.free.assign(arms.size(), 1), sharing.best.resize(arms.size());
    sharing.solve();
    if (std::ranges::all_of(sharing.best, [](double share) { return share >= 0; })) {
        std::ranges::copy(sharing.best, shares.begin());
        return;
    }
    // From the nearest point on; each round adds a point and takes away those that it makes superfluous.
    const auto nearest = std::ranges::min_element(arms, {}, [](Vec3 arm) { return dot(arm, arm); }) - arms.begin();
    std::ranges::fill(sharing.free, char{0}), std::ranges::fill(shares, 0.0);
    sharing.free[static_cast<std::size_t>(nearest)] = 1, shares[static_cast<std::size_t>(nearest)] = 1;
    for (std::size_t round = 0; round < 4 * arms.size(); ++round) {
        const std::size_t added = sharing.most_missing();
        if (added == arms.size()) break;
        sharing.free[added] = 1;
        for (std::size_t left = 0; left != arms.size();) {
            sharing.solve();
            left = sharing.approach();
            // It gains nothing but rounding.
            if (left == added) return;
        }
    }
}

}  // namespace meld::physics
