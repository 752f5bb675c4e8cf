// Bodies that were found to be apart are not compared again before they may touch: which changes nothing but the time that it takes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "physics/collision/core_contacts.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics::apart {
namespace {

ShapePart brick(Vec3 edges, Vec3 at) {
    const BodyShape solid = box_shape(edges, 0.02);
    return {solid.core_m, solid.rounding_m, at, {}, solid.volume_m3()};
}
const std::vector<BodyShape> kSome = {
    box_shape({1, 0.8, 0.4}, 0.02), box_shape({0.7, 0.5, 0.9}, 0),
    cylinder_shape(0.4, 0.6, 0.05), capsule_shape(0.25, 1.2),
    box_shape({1, 1, 1}, 0.3),      compound_of({brick({1, 0.3, 0.3}, {}), brick({0.3, 0.3, 0.7}, {0.35, 0, 0.5})}).shape};

struct Pair {
    std::mt19937 random{3};
    std::normal_distribution<double> normal;

    Vec3 vector(double size) { return {size * normal(random), size * normal(random), size * normal(random)}; }
    Quat turn(Quat from, double size) {
        const Vec3 axis = vector(0.5 * size);
        const Quat sum{from.w - axis.x * from.x - axis.y * from.y - axis.z * from.z, from.x + axis.x * from.w, from.y + axis.y * from.w,
                       from.z + axis.z * from.w};
        const double length = std::sqrt(sum.w * sum.w + sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
        return {sum.w / length, sum.x / length, sum.y / length, sum.z / length};
    }
    Core core() {
        const Vec3 half = vector(0.3);
        const std::array<Core, 3> kinds = {Core{{0.1 + std::abs(half.x), 0.1 + std::abs(half.y), 0.1 + std::abs(half.z)}, 0.01},
                                           Core{{0, 0, 0.1 + std::abs(half.z)}, 0.2}, Core{{}, 0.1 + std::abs(half.x)}};
        return kinds[std::uniform_int_distribution<std::size_t>(0, 2)(random)];
    }
};

double radius_of(const Core& core) { return length(core.half_m) + core.radius_m; }

// How far points within this distance of its centre go with a body.
double moved_m(const Pose& before, const Pose& now, double distance_m) {
    double turned = 0;
    for (std::size_t k = 0; k < 3; ++k) turned += dot(now.axes[k] - before.axes[k], now.axes[k] - before.axes[k]);
    return length(now.centre - before.centre) + std::sqrt(turned) * distance_m;
}

TEST(Apart, AsLongAsBothBodiesTogetherMoveLess) {
    Pair pair;
    constexpr double kReach_m = 0.05;
    int known = 0, kept = 0, met = 0;
    for (int trial = 0; trial < 100000; ++trial) {
        const Core a = pair.core(), b = pair.core();
        const Quat a_turn = pair.turn({}, 3), b_turn = pair.turn({}, 3);
        const Pose a_pose = pose_of({}, a_turn), b_pose = pose_of(pair.vector(0.8), b_turn);
        AxisHint hint = kNoAxis;
        Manifold found;
        collide(a, a_pose, b, b_pose, kReach_m, hint, found);
        if (found.count > 0 || found.apart_m <= kReach_m) continue;
        ++known;
        EXPECT_EQ(lasting(hint), kNoAxis);
        const double size = 0.02 * (1 + trial % 10);
        const Pose a_now = pose_of(pair.vector(size), pair.turn(a_turn, size)),
                   b_now = pose_of(b_pose.centre + pair.vector(size), pair.turn(b_turn, size));
        const double distance_m =
            std::max(length(b_pose.centre), length(b_now.centre - a_now.centre)) + std::max(radius_of(a), radius_of(b));
        const bool apart = found.apart_m - moved_m(a_pose, a_now, distance_m) - moved_m(b_pose, b_now, distance_m) > kReach_m;
        AxisHint fresh = kNoAxis;
        for (AxisHint* at : {&hint, &fresh}) {
            collide(a, a_now, b, b_now, kReach_m, *at, found);
            kept += apart ? 1 : 0;
            met += found.count > 0 ? 1 : 0;
            EXPECT_FALSE(apart && found.count > 0) << trial;
        }
    }
    EXPECT_GT(known, 10000);
    EXPECT_GT(kept, 5000);
    EXPECT_GT(met, 500);
}

// A scene that is loaded from a snapshot knows nothing of who is apart, and compares all.
TEST(Apart, TheSameBitsAsIfAllWereCompared) {
    const auto empty = [] { return scene_on_plane(); };
    auto scene = empty();
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    for (BodyId id = 0; id < 80; ++id) {
        BodySpec spec{.id = id, .position_m = {1.3 * (id % 4), 1.3 * (id / 4 % 4), 0.8 + 1.3 * (id / 16)}};
        if (id % 7 != 6) spec.shape = kSome[id % kSome.size()];
        spec.linear_velocity_m_s = {normal(random), normal(random), 0};
        spec.angular_velocity_rad_s = {2 * normal(random), 2 * normal(random), 2 * normal(random)};
        need(scene->add_body(spec));
    }
    Workers workers(1);
    for (int tick = 0; tick < 240; ++tick) {
        auto anew = loaded(saved(*scene), empty(), workers);
        run(*scene, 1, 2, workers);
        run(*anew, 1, 2, workers);
        ASSERT_EQ(anew->digest(), scene->digest()) << tick;
    }
}

}  // namespace
}  // namespace meld::physics::apart
