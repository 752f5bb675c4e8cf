#include "physics/statics/seat.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "physics/collision/core_contacts.h"

namespace meld::physics {

namespace {

// Of the solids of two compounds, those that are nearest to each other.
std::pair<std::size_t, std::size_t> nearest_solids(const Seated& one, const Seated& other) {
    const Pose a_pose = pose_of(one.place_m, one.turn), b_pose = pose_of(other.place_m, other.turn);
    double far_m = length(other.place_m - one.place_m) + one.shape.radius_m() + other.shape.radius_m();
    std::pair<std::size_t, std::size_t> nearest;
    for (std::size_t i = 0; i < one.shape.solids(); ++i)
        for (std::size_t j = 0; j < other.shape.solids(); ++j) {
            const PlacedSolid a = solid_of(one.shape, a_pose, i), b = solid_of(other.shape, b_pose, j);
            AxisHint hint = kNoAxis;
            Manifold found;
            collide(a.core, a.pose, b.core, b.pose, far_m, hint, found);
            for (int p = 0; p < found.count; ++p)
                if (const double gap = found.points[static_cast<std::size_t>(p)].gap_m; gap < far_m) far_m = gap, nearest = {i, j};
        }
    return nearest;
}

Seated solid_of(const Seated& body, std::size_t solid) {
    const ShapePart& part = body.shape.parts[solid];
    return {solid_of(part), body.place_m + rotate(body.turn, part.at_m), product(body.turn, part.turn)};
}

}  // namespace

Seat seat_between(const Seated& one, const Seated& other) {
    if (one.shape.is_compound() || other.shape.is_compound()) {
        const auto [i, j] = nearest_solids(one, other);
        return seat_between(one.shape.is_compound() ? solid_of(one, i) : one, other.shape.is_compound() ? solid_of(other, j) : other);
    }
    // Points of the two surfaces that are farther apart than the nearest ones by this share of the thinner body are not where they touch.
    constexpr double kSameGap = 0.01;
    const Core a{one.shape.core_m, one.shape.rounding_m}, b{other.shape.core_m, other.shape.rounding_m};
    const Pose a_pose = pose_of(one.place_m, one.turn), b_pose = pose_of(other.place_m, other.turn);
    const Vec3 way = other.place_m - one.place_m;
    const double far_m = length(way) + one.shape.radius_m() + other.shape.radius_m();
    Seat seat{.at = one.place_m + 0.5 * way, .radius_m = std::min(one.shape.least_m(), other.shape.least_m())};
    if (const double apart = length(way); apart > 0) seat.along = (1 / apart) * way;
    AxisHint hint = kNoAxis;
    Manifold found;
    collide(a, a_pose, b, b_pose, far_m, hint, found);
    if (found.count == 0) return seat;
    double nearest = std::numeric_limits<double>::infinity();
    for (int p = 0; p < found.count; ++p) nearest = std::min(nearest, found.points[static_cast<std::size_t>(p)].gap_m);
    // With this reach, the points left out do not push others out of the four.
    collide(a, a_pose, b, b_pose, nearest + kSameGap * 2 * seat.radius_m, hint, found);
    if (found.count == 0) return seat;
    Vec3 sum;
    for (int p = 0; p < found.count; ++p) sum = sum + found.points[static_cast<std::size_t>(p)].at;
    seat.at = one.place_m + (1 / static_cast<double>(found.count)) * sum;
    seat.along = found.normal;
    return seat;
}

}  // namespace meld::physics
