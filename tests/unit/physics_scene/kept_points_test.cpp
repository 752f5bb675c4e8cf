// Bodies that move little keep the points at which they touch, and yet stand and fall where they should.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/physics/scenes.h"

namespace meld::physics::kept_points {
namespace {

double tilt(const Scene& scene) {
    const Quat q = scene.state(0).orientation;
    return std::acos(std::min(1.0, 1 - 2 * (q.x * q.x + q.y * q.y)));
}

// It slides slowly off a table without friction, and tips when its middle is beyond the edge.
TEST(KeptPoints, ACubeTipsWhereTheEdgeIs) {
    for (const Vec3 way : {Vec3{1, 0, 0}, Vec3{0, -1, 0}}) {
        auto scene = make_scene(settings_with({0, 0, -kGravity}, 0));
        const auto smooth = need(scene->add_material({.friction = 0}));
        need(scene->add_obstacle(Box{{0, 0, -0.5}, {2, 2, 1}, {}}, smooth));
        constexpr double kBefore_m = 0.005, kSpeed_m_s = 0.01;
        need(scene->add_body({.id = 0,
                              .position_m = (1 - kBefore_m) * way + Vec3{0, 0, 0.5},
                              .linear_velocity_m_s = kSpeed_m_s * way,
                              .material = smooth,
                              .shape = box_shape({1, 1, 1}, 0.01)}));
        Workers workers(1);
        const int at_edge = static_cast<int>(kBefore_m / kSpeed_m_s / kTick);
        run(*scene, at_edge - 24, 2, workers);
        EXPECT_LT(tilt(*scene), 1e-3);
        EXPECT_NEAR(scene->state(0).position_m.z, 0.5, 1e-3);
        run(*scene, 24 + 240, 2, workers);
        // A beam that is held at its edge would have turned by 0.06.
        EXPECT_GT(tilt(*scene), 0.02);
    }
}

}  // namespace
}  // namespace meld::physics::kept_points
