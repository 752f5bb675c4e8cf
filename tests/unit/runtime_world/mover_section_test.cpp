#include <gtest/gtest.h>

#include "runtime/world/description/motions.h"
#include "tests/unit/runtime_world/parsed_world.h"

namespace meld::world {
namespace {

// Of a world whose obstacle has these keys.
Vec3 pivot_of_obstacle(const std::string& keys) {
    const World world = world_of("[[body]]\npositions = [[0, 0, 9]]\n[motion]\nkind = \"bodies\"\n[[motion.obstacle]]\n" + keys);
    return pivot_of(world.physics.obstacles.at(0));
}

TEST(ObstaclesThatMove, TurnAboutTheirMiddle) {
    EXPECT_EQ(pivot_of_obstacle("kind = \"box\"\ncentre = [1, 2, 3]\nspin = [0, 0, 1]"), (Vec3{1, 2, 3}));
    EXPECT_EQ(pivot_of_obstacle("kind = \"plane\"\nnormal = [0, 2, 0]\noffset = 4\nspin = [0, 0, 1]"), (Vec3{0, 2, 0}));
    EXPECT_EQ(pivot_of_obstacle("kind = \"terrain\"\ncentre = [1, 2, 3]\ncell = 2\nheights = [[0, 0, 0], [0, 1, 0]]\nspin = [0, 0, 1]"),
              (Vec3{3, 3, 3.5}));
}

const std::string kBodies = "[[body]]\npositions = [[0, 0, 0]]\n[motion]\nkind = \"bodies\"\n";

TEST(MoverSection, ReadsEachKey) {
    const World world = world_of(kBodies + R"toml(
[[motion.mover]]
where = "id == 0"
swing = [0, 0, 0.1]
tilt = [20, 0, 0]
frequency = 3
phase = 90
spin = [0, 0, 2]
pivot = [1, 2, 3]
[[motion.mover]]
where = "x > 2"
spin = [0, 0, 1]
[[motion.obstacle]]
kind = "plane"
belt = [0, 0.8, 0]
[[motion.obstacle]]
kind = "terrain"
centre = [2, 0, 1]
heights = [[0, 0, 0], [0, 1, 0]]
swing = [0, 0, 0.2]
tilt = [0, 5, 0]
frequency = 2
phase = 180
spin = [0, 1, 0]
pivot = [0, 0, 7]
[motion.gravity_swing]
swing = [1, 0, 0]
[[event]]
tick = 7
gravity = [0, 0, 3]
)toml");
    const PhysicsOptions& p = world.physics;
    ASSERT_EQ(p.movers.size(), 2u);
    EXPECT_EQ(p.movers[0].swing.swing, (Vec3{0, 0, 0.1}));
    EXPECT_EQ(p.movers[0].swing.tilt, (Vec3{20, 0, 0}));
    EXPECT_EQ(p.movers[0].swing.frequency, 3);
    EXPECT_EQ(p.movers[0].swing.phase, 90);
    EXPECT_EQ(p.movers[0].spin, (Vec3{0, 0, 2}));
    EXPECT_EQ(p.movers[0].pivot, (Vec3{1, 2, 3}));
    EXPECT_FALSE(p.movers[1].pivot);
    EXPECT_TRUE(p.has_belts());
    EXPECT_FALSE(p.obstacles[0].motion.moves());
    const PrescribedOptions& motion = p.obstacles[1].motion;
    EXPECT_EQ(motion.swing.swing, (Vec3{0, 0, 0.2}));
    EXPECT_EQ(motion.swing.tilt, (Vec3{0, 5, 0}));
    EXPECT_EQ(motion.swing.frequency, 2);
    EXPECT_EQ(motion.swing.phase, 180);
    EXPECT_EQ(motion.spin, (Vec3{0, 1, 0}));
    EXPECT_EQ(motion.pivot, (Vec3{0, 0, 7}));
    EXPECT_TRUE(p.moves_obstacles());
    EXPECT_EQ(p.gravity_swing->swing, (Vec3{1, 0, 0}));
    EXPECT_EQ(p.gravity_swing->frequency, 1);
    EXPECT_EQ(world.events.at(0).gravity, (Vec3{0, 0, 3}));
    EXPECT_FALSE(world_of(kBodies).physics.has_belts());
}

TEST(MoverSection, SaysWhatIsWrongAndWhere) {
    const std::string mover = "[[motion.mover]]\nwhere = \"all\"\n";
    const std::pair<std::string, std::string> wrong[] = {
        {"mover = 3", "w.toml:5:9: [motion] mover is an integer, not tables [[motion.mover]]"},
        {"[[motion.mover]]\nspin = [0, 0, 1]", "w.toml:5:1: a [[motion.mover]] moves no catoms. write where = \"id == 0\""},
        {mover, "w.toml:5:1: this [[motion.mover]] moves nothing. write swing = [0, 0, 0.1], tilt or spin"},
        {mover + "swimg = [0, 0, 1]", "w.toml:7:1: there is no key 'swimg' in [[motion.mover]]. did you mean 'swing'?"},
        {mover + "swing = 0.1", "w.toml:7:9: [[motion.mover]] swing is not a point [x, y, z] of three finite numbers"},
        {mover + "swing = [1, 0, 0]\nfrequency = 0", "w.toml:8:13: [[motion.mover]] frequency = 0 is not a number above zero"},
        {mover + "spin = [1, 0, 0]\nphase = 90", "w.toml:8:9: nothing swings here. write swing = [0, 0, 0.1], or tilt = [10, 0, 0]"},
        {mover + "swing = [1, 0, 0]\npivot = [1, 0, 0]", "w.toml:8:9: nothing turns about this pivot. write spin or tilt, too"},
        {"engine = \"hash\"\n" + mover + "spin = [0, 0, 1]",
         "w.toml:5:10: the engine \"hash\" has no movers and no belts. write engine = \"blocks\", or take [[motion.mover]] and belt out"},
        {"[[motion.obstacle]]\nkind = \"plane\"\nbelt = 2",
         "w.toml:7:8: [[motion.obstacle]] belt is not a point [x, y, z] of three finite numbers"},
        {"[[motion.obstacle]]\nkind = \"plane\"\nspin = 2",
         "w.toml:7:8: [[motion.obstacle]] spin is not a point [x, y, z] of three finite numbers"},
        {"[[motion.obstacle]]\nkind = \"sphere\"\nfrequency = 2",
         "w.toml:7:13: nothing swings here. write swing = [0, 0, 0.1], or tilt = [10, 0, 0]"},
        {"[[motion.obstacle]]\nkind = \"box\"\nswing = [1, 0, 0]\npivot = [1, 0, 0]",
         "w.toml:8:9: nothing turns about this pivot. write spin or tilt, too"},
        {"[[motion.obstacle]]\nkind = \"box\"\ntilted = [1, 0, 0]",
         "w.toml:7:1: there is no key 'tilted' in [[motion.obstacle]]. did you mean 'tilt'?"},
        {"engine = \"hash\"\n[[motion.obstacle]]\nkind = \"box\"\nspin = [1, 0, 0]",
         "w.toml:5:10: the engine \"hash\" has no obstacles that move. write engine = \"blocks\", or take swing, tilt and spin of "
         "[[motion.obstacle]] out"},
        {"[motion.gravity_swing]\nfrequency = 2", "w.toml:6:13: nothing swings here. write swing = [0, 0, 0.1], or tilt = [10, 0, 0]"},
        {"[motion.gravity_swing]\n", "w.toml:5:1: this [motion.gravity_swing] does nothing. write swing = [1, 0, 0], or tilt = [10, 0, 0]"},
        {"gravity_swing = 2", "w.toml:5:17: [motion] gravity_swing is an integer, not a table [motion.gravity_swing]"},
        {"[[event]]\ntick = 3\ngravity = -9.81", "w.toml:7:11: [[event]] gravity is not a point [x, y, z] of three finite numbers"},
    };
    for (const auto& [line, message] : wrong) {
        const std::string found = error_of(kBodies + line + "\n");
        EXPECT_TRUE(found.starts_with(message)) << line << "\n" << found;
    }
    EXPECT_EQ(error_of("[[body]]\nshape = \"box(2, 2, 2)\"\n[[event]]\ntick = 1\ngravity = [0, 0, 1]\n"),
              "w.toml:5:11: only bodies feel gravity, and these catoms are none. take it out, or write [motion] kind = \"bodies\"");
}

}  // namespace
}  // namespace meld::world
