// Where obstacles stand in pictures.
#include "runtime/show/picture/obstacles.h"

#include <gtest/gtest.h>

#include <optional>

namespace meld::picture {
namespace {

render::Scene scene_with_plane(world::Vec3 normal, double offset) {
    world::World world;
    world.motion.kind = "bodies";
    world::ObstacleOptions& plane = world.physics.obstacles.emplace_back();
    plane.normal = normal, plane.offset = offset;
    render::Scene scene;
    add_obstacles(world, 0, scene);
    return scene;
}

// The points p with normal * p = offset.
TEST(DrawnObstacles, APlaneIsWhereItIsForBodiesWhateverItsNormalsLength) {
    for (const double length : {1.0, 4.0, 0.5})
        EXPECT_EQ(scene_with_plane({0, 0, length}, 3 * length).ground, std::optional(3.0F)) << length;
    const render::Scene wall = scene_with_plane({-2, 0, 0}, 6);
    ASSERT_FALSE(wall.obstacles.empty());
    for (const render::Triangle& triangle : wall.obstacles)
        for (const render::Vec& corner : triangle) EXPECT_FLOAT_EQ(corner.x(), -3);
}

}  // namespace
}  // namespace meld::picture
