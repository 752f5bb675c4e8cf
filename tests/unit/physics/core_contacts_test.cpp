// Where rounded shapes touch, against a slow and obvious way to find the nearest points of two convex cores.
#include "physics/collision/core_contacts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "physics/bodies/symmetric.h"

namespace meld::physics {
namespace {

bool is_cylinder(const Core& core) { return core.half_m.x > 0 && core.half_m.y == 0; }

Vec3 nearest_in_core(const Core& core, const Pose& pose, Vec3 point) {
    const Vec3 way = point - pose.centre;
    const Vec3 half = core.half_m;
    if (is_cylinder(core)) {
        const double up = dot(way, pose.axes[2]);
        const Vec3 across = way - up * pose.axes[2];
        const double away = length(across);
        return pose.centre + (away > half.x ? half.x / away : 1) * across + std::clamp(up, -half.z, half.z) * pose.axes[2];
    }
    const double x = std::clamp(dot(way, pose.axes[0]), -half.x, half.x), y = std::clamp(dot(way, pose.axes[1]), -half.y, half.y),
                 z = std::clamp(dot(way, pose.axes[2]), -half.z, half.z);
    return pose.centre + x * pose.axes[0] + (y * pose.axes[1] + z * pose.axes[2]);
}

// Goes to and fro between the cores, each time to the nearest point of the other: this comes as near to their distance as one likes.
double distance_of_cores(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose) {
    Vec3 p = a_pose.centre, q = b_pose.centre;
    double distance = length(q - p);
    for (int i = 0; i < 20000; ++i) {
        p = nearest_in_core(a, a_pose, q), q = nearest_in_core(b, b_pose, p);
        const double now = length(q - p);
        if (i > 50 && distance - now < 1e-13) return now;
        distance = now;
    }
    return distance;
}

double reach_along(const Core& core, const Pose& pose, Vec3 direction) {
    if (is_cylinder(core)) {
        const double up = dot(direction, pose.axes[2]);
        return core.half_m.x * std::sqrt(std::max(1 - up * up, 0.0)) + core.half_m.z * std::abs(up);
    }
    return core.half_m.x * std::abs(dot(direction, pose.axes[0])) + core.half_m.y * std::abs(dot(direction, pose.axes[1])) +
           core.half_m.z * std::abs(dot(direction, pose.axes[2]));
}

// How far cores must be moved apart at least, over very many directions, and the best of them refined.
double overlap_of_cores(const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose, std::mt19937& random) {
    std::normal_distribution<double> normal;
    const Vec3 shift = b_pose.centre - a_pose.centre;
    const auto overlap = [&](Vec3 direction) {
        return reach_along(a, a_pose, direction) + reach_along(b, b_pose, direction) - dot(direction, shift);
    };
    const auto unit = [](Vec3 v) { return (1 / length(v)) * v; };
    Vec3 best{0, 0, 1};
    for (int i = 0; i < 3000; ++i)
        if (const Vec3 tried = unit({normal(random), normal(random), normal(random)}); overlap(tried) < overlap(best)) best = tried;
    for (double step = 0.1; step > 1e-7; step *= 0.7)
        for (int i = 0; i < 40; ++i)
            if (const Vec3 tried = unit(best + step * Vec3{normal(random), normal(random), normal(random)}); overlap(tried) < overlap(best))
                best = tried;
    return overlap(best);
}

struct Placed {
    Core core;
    Pose pose;
    double least() const {
        if (is_cylinder(core)) return core.radius_m + std::min(core.half_m.x, core.half_m.z);
        return core.radius_m + std::min({core.half_m.x, core.half_m.y, core.half_m.z});
    }
};

Placed random_body(std::mt19937& random, double spread) {
    std::uniform_real_distribution<double> size(0.1, 0.6), round(0.02, 0.3), where(-spread, spread);
    std::normal_distribution<double> normal;
    Placed body;
    const int kind = std::uniform_int_distribution<int>(0, 7)(random);
    if (kind == 0) body.core = {{}, 0.1 + size(random)};
    if (kind == 1) body.core = {{0, 0, size(random)}, round(random)};
    if (kind >= 2) body.core = {{size(random), size(random), size(random)}, kind == 4 || kind == 7 ? 0 : round(random)};
    if (kind >= 5) body.core.half_m.y = 0;
    Quat turn{normal(random), normal(random), normal(random), normal(random)};
    // Some lie along the axes, so that faces and edges are parallel.
    if (std::uniform_int_distribution<int>(0, 3)(random) == 0) turn = {1, 0, 0, 0};
    const double norm = std::sqrt(turn.w * turn.w + turn.x * turn.x + turn.y * turn.y + turn.z * turn.z);
    body.pose = pose_of({where(random), where(random), where(random)}, {turn.w / norm, turn.x / norm, turn.y / norm, turn.z / norm});
    return body;
}

double least_gap(const Manifold& found) {
    double least = HUGE_VAL;
    for (int p = 0; p < found.count; ++p) least = std::min(least, found.points[static_cast<std::size_t>(p)].gap_m);
    return least;
}

Manifold contacts_of(const Placed& a, const Placed& b, double reach_m) {
    Manifold found;
    AxisHint hint = kNoAxis;
    collide(a.core, a.pose, b.core, b.pose, reach_m, hint, found);
    return found;
}

TEST(CoreContacts, GapsAreTheDistancesOfShapesThatAreApart) {
    std::mt19937 random(1);
    int apart = 0, near = 0;
    for (int i = 0; i < 4000; ++i) {
        const Placed a = random_body(random, 0.7), b = random_body(random, 0.7);
        const double cores = distance_of_cores(a.core, a.pose, b.core, b.pose);
        if (cores < 1e-4) continue;
        ++apart;
        const double gap = cores - a.core.radius_m - b.core.radius_m, reach = 0.2;
        const Manifold found = contacts_of(a, b, reach);
        // Faces that are nearly parallel meet in points along the normal of one of them.
        const double tolerance = 1e-2 * std::min(a.least(), b.least()) + 0.02 * cores;
        if (gap > reach + tolerance) {
            EXPECT_EQ(found.count, 0) << i;
            continue;
        }
        if (gap > reach - tolerance) continue;
        ++near;
        ASSERT_GT(found.count, 0) << i;
        EXPECT_NEAR(least_gap(found), gap, tolerance) << i;
        EXPECT_NEAR(length(found.normal), 1, 1e-9) << i;
        for (int p = 0; p < found.count; ++p) {
            // Midway between both surfaces: no farther from either core than that, unless they overlap by more than a radius.
            const ManifoldPoint& point = found.points[static_cast<std::size_t>(p)];
            if (-point.gap_m > std::min(a.core.radius_m, b.core.radius_m)) continue;
            for (const Placed* body : {&a, &b}) {
                const Vec3 at = a.pose.centre + point.at, on = nearest_in_core(body->core, body->pose, at);
                EXPECT_LT(length(at - on), body->core.radius_m + std::max(point.gap_m / 2, 0.0) + tolerance) << i;
            }
        }
        const Manifold other = contacts_of(b, a, reach);
        EXPECT_NEAR(least_gap(other), least_gap(found), tolerance) << i;
        EXPECT_GT(dot(other.normal, found.normal), -1.001) << i;
        EXPECT_LT(dot(other.normal, found.normal), -0.97) << i;
    }
    EXPECT_GT(apart, 1000);
    EXPECT_GT(near, 500);
}

TEST(CoreContacts, OverlapsAreTheLeastWayApart) {
    std::mt19937 random(2);
    int overlapping = 0;
    for (int i = 0; i < 600; ++i) {
        const Placed a = random_body(random, 0.3), b = random_body(random, 0.3);
        if (a.core.half_m.x == 0 && b.core.half_m.x == 0) continue;
        if (distance_of_cores(a.core, a.pose, b.core, b.pose) > 1e-6) continue;
        const double depth = overlap_of_cores(a.core, a.pose, b.core, b.pose, random);
        if (depth < 1e-3) continue;
        ++overlapping;
        const Manifold found = contacts_of(a, b, 0);
        ASSERT_GT(found.count, 0) << i;
        // A face is preferred to edges that are hardly better, and of an inner point the nearest face is taken.
        const double expected = depth + a.core.radius_m + b.core.radius_m;
        // Rims are sought by trying directions.
        const bool rims = is_cylinder(a.core) || is_cylinder(b.core);
        EXPECT_LT(-least_gap(found), (rims ? 1.05 : 1.02) * expected + 1e-3) << i;
        // Moved apart by that way, they just touch.
        Placed moved = b;
        moved.pose.centre = b.pose.centre - least_gap(found) * found.normal;
        EXPECT_NEAR(distance_of_cores(a.core, a.pose, moved.core, moved.pose), a.core.radius_m + b.core.radius_m, 0.02 * expected + 1e-3)
            << i;
    }
    EXPECT_GT(overlapping, 200);
}

TEST(CoreContacts, ABoxLiesOnFourPoints) {
    const Core box{{0.5, 0.5, 0.5}, 0}, plate{{3, 3, 0.1}, 0};
    const Pose above = pose_of({0.2, 0.1, 0.599}, {std::cos(0.2), 0, 0, std::sin(0.2)});
    AxisHint hint = kNoAxis;
    Manifold found;
    collide(plate, pose_of({}, {}), box, above, 0.01, hint, found);
    ASSERT_EQ(found.count, 4);
    EXPECT_NEAR(found.normal.z, 1, 1e-12);
    Vec3 sum;
    for (const ManifoldPoint& point : found.points) {
        EXPECT_NEAR(point.gap_m, -0.001, 1e-9);
        EXPECT_NEAR(point.at.z, 0.0995, 1e-9);
        sum = sum + point.at;
    }
    EXPECT_NEAR(sum.x / 4, 0.2, 1e-9);
    EXPECT_NEAR(sum.y / 4, 0.1, 1e-9);
    // Turned by an eighth over a face of its own size, an octagon is common to both: four of its corners.
    collide(box, pose_of({}, {}), box, pose_of({0, 0, 0.999}, {std::cos(M_PI / 8), 0, 0, std::sin(M_PI / 8)}), 0.01, hint, found);
    EXPECT_EQ(found.count, 4);
}

TEST(CoreContacts, ACapsuleLiesOnTwoPointsAndStandsOnOne) {
    const Core capsule{{0, 0, 0.5}, 0.25};
    const Quat lying{std::cos(M_PI / 4), std::sin(M_PI / 4), 0, 0};
    Manifold found;
    AxisHint hint = kNoAxis;
    collide_with_plane(capsule, pose_of({0, 0, 0.25}, lying), {0, 0, 1}, 0, 0.01, hint, found);
    EXPECT_EQ(found.count, 2);
    collide_with_plane(capsule, pose_of({0, 0, 0.75}, {}), {0, 0, 1}, 0, 0.01, hint, found);
    ASSERT_EQ(found.count, 1);
    EXPECT_NEAR(found.points[0].gap_m, 0, 1e-12);
    EXPECT_NEAR(found.points[0].at.z, -0.75, 1e-12);
    const Core box{{1, 1, 1}, 0};
    collide(box, pose_of({}, {}), capsule, pose_of({0.9, 0, 1.25}, lying), 0.01, hint, found);
    EXPECT_EQ(found.count, 2);
    // Two side by side, and two crosswise.
    collide(capsule, pose_of({}, lying), capsule, pose_of({0.4, 0.3, 0}, lying), 0.01, hint, found);
    EXPECT_EQ(found.count, 2);
    collide(capsule, pose_of({}, lying), capsule, pose_of({0, 0, 0.5}, {std::cos(M_PI / 4), 0, std::sin(M_PI / 4), 0}), 0.01, hint, found);
    ASSERT_EQ(found.count, 1);
    EXPECT_NEAR(found.points[0].gap_m, 0, 1e-9);
}

Quat turned_about(Vec3 axis, double angle) {
    const double s = std::sin(angle / 2);
    return {std::cos(angle / 2), s * axis.x, s * axis.y, s * axis.z};
}

Vec3 mean_of(const Manifold& found) {
    Vec3 sum;
    for (int p = 0; p < found.count; ++p) sum = sum + found.points[static_cast<std::size_t>(p)].at;
    return (1.0 / found.count) * sum;
}

// Whether a place, seen from above, is among the points.
bool holds(const Manifold& found, Vec3 place) {
    for (double angle = 0; angle < 6.28; angle += 0.01) {
        double most = -1;
        for (int p = 0; p < found.count; ++p) {
            const Vec3 way = found.points[static_cast<std::size_t>(p)].at - place;
            most = std::max(most, way.x * std::cos(angle) + way.y * std::sin(angle));
        }
        if (most < 0) return false;
    }
    return true;
}

TEST(CoreContacts, ACylinderStandsOnFourPointsOfItsRimAndLiesOnTwo) {
    const Core can{{0.5, 0, 0.8}, 0.1};
    Manifold found;
    AxisHint hint = kNoAxis;
    for (const double angle : {0.0, 1e-3, 0.05}) {
        // Leant over to where the x and y axes are alike.
        const Quat leant = turned_about({-std::sqrt(0.5), std::sqrt(0.5), 0}, angle);
        const double height = 0.5 * std::sin(angle) + 0.8 * std::cos(angle) + 0.1;
        collide_with_plane(can, pose_of({0, 0, height}, leant), {0, 0, 1}, 0, 0.1, hint, found);
        ASSERT_EQ(found.count, 4) << angle;
        // Where it leans but a little, the lowest of its places is hardly higher.
        EXPECT_NEAR(least_gap(found), 0, angle < 1e-2 ? 0.15 * angle + 1e-12 : 1e-12) << angle;
        int lowest = 0;
        for (const ManifoldPoint& point : found.points) {
            EXPECT_LT(point.gap_m, 1.001 * std::sin(angle) + 1e-9) << angle;
            EXPECT_NEAR(std::hypot(point.at.x, point.at.y), 0.5, 1.1 * std::sin(angle) + 1e-9);
            if (angle < 1e-2 || point.gap_m > 1e-9) continue;
            // The lowest point is exactly on that side.
            ++lowest;
            EXPECT_NEAR(point.at.x, point.at.y, 1e-6);
            EXPECT_GT(point.at.x, 0.3);
        }
        EXPECT_EQ(lowest, angle < 1e-2 ? 0 : 1);
    }
    const Quat lying = turned_about({1, 0, 0}, M_PI / 2);
    collide_with_plane(can, pose_of({0, 0, 0.6}, lying), {0, 0, 1}, 0, 0.01, hint, found);
    ASSERT_EQ(found.count, 2);
    for (int p = 0; p < 2; ++p) {
        EXPECT_NEAR(found.points[static_cast<std::size_t>(p)].gap_m, 0, 1e-12);
        EXPECT_NEAR(std::abs(found.points[static_cast<std::size_t>(p)].at.y), 0.8, 1e-12);
    }
    collide_with_plane(can, pose_of({0, 0, 1}, turned_about({1, 0, 0}, M_PI / 3)), {0, 0, 1}, 0, 1, hint, found);
    EXPECT_NEAR(least_gap(found), 1 - 0.1 - 0.8 * std::cos(M_PI / 3) - 0.5 * std::sin(M_PI / 3), 1e-12);
}

TEST(CoreContacts, CylindersMeetFlatAlongTheirSidesAndCrosswise) {
    const Core can{{0.5, 0, 0.8}, 0.1}, sharp{{0.6, 0, 0.9}, 0}, plate{{3, 3, 0.1}, 0}, small{{0.1, 0.1, 0.1}, 0};
    AxisHint hint = kNoAxis;
    Manifold found;
    const auto contacts = [&](const Core& a, const Pose& a_pose, const Core& b, const Pose& b_pose) {
        collide(a, a_pose, b, b_pose, 0.02, hint, found);
        const Vec3 normal = found.normal, mean = found.count > 0 ? mean_of(found) : Vec3{};
        const int count = found.count;
        const double gap = least_gap(found);
        collide(b, b_pose, a, a_pose, 0.02, hint, found);
        EXPECT_EQ(found.count, count);
        if (count == 0) return count;
        EXPECT_NEAR(length(found.normal + normal), 0, 1e-9);
        // Points on a rim are those of the first body.
        EXPECT_NEAR(length(mean_of(found) + b_pose.centre - a_pose.centre - mean), 0, found.on_rim ? 0.5 : 1e-9);
        EXPECT_NEAR(least_gap(found), gap, 1e-9);
        return count;
    };
    const Quat lying = turned_about({1, 0, 0}, M_PI / 2), across = turned_about({0, 1, 0}, M_PI / 2);
    for (const Core& one : {can, sharp})
        for (const double gap : {-1e-4, 1e-4}) {
            const double high = 0.9, wide = 0.6;
            // On another one, in the middle and at its edge; on a plate and on a small cube.
            for (const double off : {0.0, 0.4}) {
                EXPECT_EQ(contacts(one, pose_of({}, {}), one, pose_of({off, 0, 2 * high + gap}, turned_about({0, 0, 1}, 0.3))), 4) << off;
                EXPECT_NEAR(least_gap(found), gap, 1e-9);
                EXPECT_NEAR(found.normal.z, -1, 1e-9);
                EXPECT_TRUE(holds(found, {-off / 2, 0, 0}));
            }
            EXPECT_EQ(contacts(plate, pose_of({}, {}), one, pose_of({0.3, 0.2, 0.1 + high + gap}, {})), 4);
            EXPECT_NEAR(mean_of(found).z, -high - gap / 2, 1e-9);
            EXPECT_TRUE(holds(found, {}));
            EXPECT_EQ(contacts(small, pose_of({}, {}), one, pose_of({0.3, 0.2, 0.1 + high + gap}, {})), 4);
            EXPECT_NEAR(mean_of(found).x, -0.3, 1e-9);
            // Half over the edge of a plate.
            EXPECT_GE(contacts(plate, pose_of({}, {}), one, pose_of({3, 0, 0.1 + high + gap}, {})), 3);
            EXPECT_NEAR(least_gap(found), gap, 1e-9);
            for (int p = 0; p < found.count; ++p) EXPECT_LT(found.points[static_cast<std::size_t>(p)].at.x, 1e-9);
            // Lying on a plate, beside another one and crosswise on it.
            EXPECT_EQ(contacts(plate, pose_of({}, {}), one, pose_of({0.3, 0.2, 0.1 + wide + gap}, lying)), 2);
            EXPECT_EQ(contacts(one, pose_of({}, {}), one, pose_of({0, 2 * wide + gap, 0.3}, {})), 2);
            EXPECT_NEAR(least_gap(found), gap, 1e-9);
            EXPECT_NEAR(mean_of(found).z, -0.15, 1e-9);
            EXPECT_EQ(contacts(one, pose_of({}, lying), one, pose_of({0.1, 0.2, 2 * wide + gap}, across)), 1);
            EXPECT_NEAR(least_gap(found), gap, 1e-9);
            // Its side on the edge of a cap of another one; and the edge of a cube along it.
            EXPECT_EQ(contacts(one, pose_of({}, {}), one, pose_of({0, 0, high + wide + gap}, lying)), 2);
            EXPECT_NEAR(least_gap(found), gap, 1e-9);
            const Core cube{{0.5, 0.5, 0.5}, 0};
            EXPECT_EQ(
                contacts(one, pose_of({}, {}), cube, pose_of({0, wide + std::sqrt(0.5) + gap, 0.2}, turned_about({0, 0, 1}, M_PI / 4))), 2);
            EXPECT_NEAR(least_gap(found), gap, 1e-9);
            // A ball on a cap and at the side, a capsule along both.
            const Core ball{{}, 0.3}, capsule{{0, 0, 0.3}, 0.3};
            EXPECT_EQ(contacts(one, pose_of({}, {}), ball, pose_of({0.2, 0.1, high + 0.3 + gap}, {})), 1);
            EXPECT_NEAR(least_gap(found), gap, 1e-9);
            EXPECT_EQ(contacts(one, pose_of({}, {}), ball, pose_of({wide + 0.3 + gap, 0, 0.1}, {})), 1);
            EXPECT_NEAR(least_gap(found), gap, 1e-9);
            EXPECT_EQ(contacts(one, pose_of({}, {}), capsule, pose_of({0.2, 0.1, high + 0.3 + gap}, lying)), 2);
            EXPECT_EQ(contacts(one, pose_of({}, {}), capsule, pose_of({wide + 0.3 + gap, 0, 0.1}, {})), 2);
            EXPECT_EQ(contacts(one, pose_of({}, {}), capsule, pose_of({0.2, 0.1, high + 0.6 + gap}, {})), 1);
            EXPECT_NEAR(least_gap(found), gap, 1e-9);
        }
}

TEST(CoreContacts, ACylinderThatRollsMovesItsPointsSmoothly) {
    // A rim rolls around on a cube and leans more and more: the point follows it without jumps, and so does the normal.
    const Core can{{0.5, 0, 0.3}, 0.05}, cube{{2, 2, 2}, 0.05};
    AxisHint hint = kNoAxis;
    Manifold before, found;
    for (int i = 0; i < 2000; ++i) {
        const double angle = 0.03 * i, lean = 0.0007 * i;
        const Vec3 about{std::cos(angle), std::sin(angle), 0};
        const double height = 2.05 + 0.05 + 0.5 * std::sin(lean) + 0.3 * std::abs(std::cos(lean)) - 1e-4;
        collide(cube, pose_of({}, {}), can, pose_of({0.1, 0.2, height}, turned_about(about, lean)), 0.005, hint, found);
        ASSERT_GT(found.count, 0) << i;
        // On its places, while it leans but a little, it may be higher, as between quarters of its rim.
        EXPECT_NEAR(least_gap(found), -1e-4, lean < 0.03 ? 0.15 * lean + 1e-9 : 2e-6) << i;
        EXPECT_GT(found.normal.z, 1 - 1e-9) << i;
    }
}

}  // namespace
}  // namespace meld::physics
