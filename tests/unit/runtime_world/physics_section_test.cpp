#include <gtest/gtest.h>

#include "runtime/world/description/populate.h"
#include "runtime/world/file/world_file.h"
#include "runtime/world/lists/positions_file.h"
#include "tests/unit/runtime_world/parsed_world.h"

namespace meld::world {
namespace {

const std::string kFree = "[[body]]\nshape = \"box(2, 2, 2)\"\n[motion]\nkind = \"bodies\"\n";

TEST(PhysicsSection, TheFormerNameOfBodiesIsAccepted) {
    const World world = world_of("[[body]]\npositions = [[0, 0, 1]]\n[motion]\nkind = \"ode\"\nmass = 3\n");
    EXPECT_EQ(world.motion.kind, "bodies");
    EXPECT_EQ(world.physics.mass, 3);
}

// Lengths with the diameter, times and speeds with its root, torques with the weight times the diameter; what is given stays.
TEST(PhysicsSection, DefaultsFollowTheSizeOfCatoms) {
    const std::string features = "[[motion.feature]]\ndirections = 6\n[[motion.feature]]\nkind = \"plate\"\ndirections = 6\narea = 0.5\n";
    const PhysicsOptions metre = world_of(kFree + features).physics,
                         small = world_of("radius = 0.005\n" + kFree + "mass = 0.01\n" + features).physics;
    EXPECT_EQ(metre.step, 1.0 / 240);
    EXPECT_DOUBLE_EQ(small.step, 1.0 / 2400);
    EXPECT_DOUBLE_EQ(small.greatest_speed, metre.greatest_speed / 10);
    EXPECT_DOUBLE_EQ(small.sense.velocity, metre.sense.velocity / 10);
    EXPECT_EQ(small.sense.position, metre.sense.position);
    EXPECT_DOUBLE_EQ(small.roll_torque, metre.roll_torque / 10'000);
    EXPECT_DOUBLE_EQ(small.features[0].depth, metre.features[0].depth / 100);
    EXPECT_DOUBLE_EQ(small.features[0].range, metre.features[0].range / 100);
    EXPECT_DOUBLE_EQ(small.features[1].cover, metre.features[1].cover / 100);
    EXPECT_EQ(small.features[1].area, 0.5);
    // The smallest catom counts, and strong gravity.
    EXPECT_DOUBLE_EQ(world_of(kFree + "[[motion.catoms]]\nwhere = \"id == 0\"\nradius = 0.125\n").physics.step, 0.5 / 240);
    EXPECT_DOUBLE_EQ(world_of(kFree + "gravity = [0, 0, -981]\n").physics.step, 0.1 / 240);
    EXPECT_EQ(world_of(kFree + "gravity = [0, 0, 0]\n").physics.step, 1.0 / 240);
}

// A tick of these worlds lasts a step times steps, also where an event says its time in seconds.
TEST(PhysicsSection, EventsInSecondsGoByTheStep) {
    const World world = world_of("[[event]]\ntime = \"1 s\"\ngive = { go = [\"id == 0\"] }\n" + kFree + "steps = 24\n");
    ASSERT_EQ(world.events.size(), 1u);
    EXPECT_EQ(world.events[0].tick, 10);
}

TEST(PhysicsSection, ReadsEachKey) {
    const World world = world_of(R"toml(
radius = 0.25
[[body]]
shape = "box(2, 2, 2)"
[[body]]
positions = [[10, 0, 0.5], [11.5, -2, 0.5]]
[motion]
kind = "bodies"
engine = "hash"
solver = "pgs20"
step = "2ms"
substeps = 4
steps = 5
gravity = [0, 1, -2]
linear_damping = 0.5
angular_damping = 0.25
mass = 3
inertia = 0.6
friction = 0.7
restitution = 0.1
spacing = 1.5
ground = -1
roll_torque = 2
sleep_ticks = 0
sleep_speed = 0.1
greatest_speed = 20
lowest = -7.5
lost = "remove"
deepest_overlap = 0.25
breaking_force = 120
breaking_torque = 7.5
[motion.sense]
position = 0.5
load = 0.3
pressure = 0
[[motion.feature]]
kind = "two-pole"
directions = 12
strength = 5
range = 0.3
[[motion.feature]]
kind = "latch"
directions = [[0, 0, 1], [1, 0, 0]]
[[motion.obstacle]]
kind = "box"
centre = [1, 2, 3]
size = [4, 5, 6]
degrees = 30
friction = 0
[[motion.obstacle]]
kind = "terrain"
heights = [[0, 1, 0], [1, 2, 1]]
[[motion.catoms]]
where = "id < 2"
radius = 0.125
mass = 9
fixed = true
connected = true
breaking_force = 30
breaking_torque = 2
velocity = [1, 0, 0]
)toml");
    const PhysicsOptions& p = world.physics;
    EXPECT_TRUE(world.is_free());
    EXPECT_EQ(count_catoms(world, Lattice(world.lattice)), 10u);
    EXPECT_EQ(world.placed[1].position, (Vec3{11.5, -2, 0.5}));
    EXPECT_EQ(p.engine, "hash");
    EXPECT_EQ(p.solver, "pgs20");
    EXPECT_EQ(p.step, 2e-3);
    EXPECT_EQ(p.substeps, 4);
    EXPECT_DOUBLE_EQ(world.tick_seconds, 10e-3);
    EXPECT_EQ(p.gravity, (Vec3{0, 1, -2}));
    EXPECT_EQ(p.linear_damping, 0.5);
    EXPECT_EQ(p.angular_damping, 0.25);
    EXPECT_EQ(p.mass, 3);
    EXPECT_EQ(p.inertia, 0.6);
    EXPECT_EQ(p.friction, 0.7);
    EXPECT_EQ(p.restitution, 0.1);
    EXPECT_EQ(p.spacing, 1.5);
    EXPECT_EQ(p.ground, -1);
    EXPECT_EQ(p.roll_torque, 2);
    EXPECT_EQ(p.sleep_ticks, 0);
    EXPECT_EQ(p.sleep_speed, 0.1);
    EXPECT_EQ(p.greatest_speed, 20);
    EXPECT_EQ(p.deepest_overlap, 0.25);
    EXPECT_EQ(p.lowest, -7.5);
    EXPECT_EQ(p.lost, "remove");
    EXPECT_EQ(p.breaking_force, 120);
    EXPECT_EQ(p.breaking_torque, 7.5);
    EXPECT_EQ(p.sense.position, 0.5);
    EXPECT_EQ(p.sense.load, 0.3);
    EXPECT_EQ(p.sense.pressure, 0);
    ASSERT_EQ(p.features.size(), 2u);
    EXPECT_EQ(p.features[0].kind, "two-pole");
    EXPECT_EQ(p.features[0].count, 12);
    EXPECT_EQ(p.features[1].directions.size(), 2u);
    ASSERT_EQ(p.obstacles.size(), 2u);
    EXPECT_EQ(p.obstacles[0].size, (Vec3{4, 5, 6}));
    EXPECT_EQ(p.obstacles[0].friction, 0);
    EXPECT_EQ(p.obstacles[1].heights.size(), 2u);
    ASSERT_EQ(p.groups.size(), 1u);
    EXPECT_EQ(p.groups[0].radius, 0.125);
    EXPECT_EQ(p.groups[0].mass, 9);
    EXPECT_EQ(p.groups[0].fixed, true);
    EXPECT_EQ(p.groups[0].connected, true);
    EXPECT_FALSE(p.groups[0].friction);
}

TEST(PhysicsSection, HasThePatchesThatResistRollingAndSpinning) {
    const World world = world_of(kFree + R"toml(rolling_friction = 0.01
[[motion.obstacle]]
kind = "plane"
spinning_friction = 0.02
[[motion.catoms]]
where = "id < 2"
rolling_friction = 0
spinning_friction = 0.03
)toml");
    const PhysicsOptions& p = world.physics;
    EXPECT_TRUE(p.resists_turning());
    EXPECT_EQ(p.rolling_friction, 0.01);
    EXPECT_EQ(p.spinning_friction, 0);
    EXPECT_FALSE(p.obstacles[0].rolling_friction);
    EXPECT_EQ(p.obstacles[0].spinning_friction, 0.02);
    EXPECT_EQ(p.groups[0].rolling_friction, 0);
    EXPECT_EQ(p.groups[0].spinning_friction, 0.03);
    EXPECT_FALSE(world_of(kFree).physics.resists_turning());
}

TEST(PhysicsSection, OnlyBlocksAreSoftUnlessToldOtherwise) {
    EXPECT_EQ(world_of(kFree).physics.solver, "soft");
    EXPECT_EQ(world_of(kFree + "engine = \"hash\"\n").physics.solver, "pgs20");
    EXPECT_EQ(world_of(kFree + "engine = \"ode\"\n").physics.solver, "pgs20");
}

TEST(PhysicsSection, SaysWhatIsWrongAndWhere) {
    const std::pair<std::string, std::string> wrong[] = {
        {"engin = \"ode\"", "w.toml:5:1: there is no key 'engin' in [motion]. did you mean 'engine'?"},
        {"engine = \"odd\"", "w.toml:5:10: [motion] engine = \"odd\" does not exist. did you mean 'ode'?"},
        {"engine = \"hash\"\nsolver = \"soft\"",
         "w.toml:6:10: the engine \"hash\" has no soft contacts. take solver out, which means \"pgs20\" here, or write engine = "
         "\"blocks\""},
        {"mass = 0", "w.toml:5:8: [motion] mass = 0 is not a number above zero"},
        {"mass = nan", "w.toml:5:8: [motion] mass = nan is not a number above zero"},
        {"friction = -1", "w.toml:5:12: [motion] friction = -1 is less than 0"},
        {"rolling_friction = -1", "w.toml:5:20: [motion] rolling_friction = -1 is less than 0"},
        {"engine = \"hash\"\nspinning_friction = 0.1",
         "w.toml:5:10: the engine \"hash\" has no friction against rolling and spinning. write engine = \"blocks\", or take "
         "rolling_friction and spinning_friction out"},
        {"restitution = 2", "w.toml:5:15: [motion] restitution = 2 is not between 0 and 1"},
        {"spacing = 0.5", "w.toml:5:11: [motion] spacing = 0.5 is less than 0.9"},
        {"gravity = 9.81", "w.toml:5:11: [motion] gravity is not a point [x, y, z] of three finite numbers"},
        {"gravity = [0, 0, inf]", "w.toml:5:11: [motion] gravity is not a point [x, y, z] of three finite numbers"},
        {"step = \"0s\"", "w.toml:5:8: [motion] step is not above zero"},
        {"substeps = 0", "w.toml:5:12: [motion] substeps = 0 is not between 1 and 2147483647"},
        {"capacity = 2", "w.toml:5:1: there is no key 'capacity' in [motion]"},
        {"sense = 3", "w.toml:5:9: [motion] sense is an integer, not a table [motion.sense]"},
        {"[[motion.feature]]\ndirections = 7",
         "w.toml:6:14: [[motion.feature]] directions = 7 is not 6, 12 or 24. list others as an array of [x, y, z]"},
        {"[[motion.feature]]\nkind = \"latch\"",
         "w.toml:5:1: a [[motion.feature]] has no directions. write directions = 6, 12 or 24, or an array of [x, y, z]"},
        {"[[motion.obstacle]]\nkind = \"cube\"", "w.toml:6:8: [[motion.obstacle]] kind = \"cube\" does not exist"},
        {"[[motion.obstacle]]\nkind = \"terrain\"\nheights = [[1, 2], [1]]",
         "w.toml:7:20: the rows of a terrain's heights are of different lengths"},
        {"[[motion.obstacle]]\nkind = \"plane\"\ncentre = [0, 0, -5]",
         "w.toml:7:10: a plane has no centre. it has normal, offset; centre is of a box"},
        {"[[motion.obstacle]]\nkind = \"box\"\nheights = [[1]]",
         "w.toml:7:11: a box has no heights. it has centre, size, degrees, turned, rounding; heights is of a terrain"},
        {"[[motion.obstacle]]\nkind = \"sphere\"\nturned = [0, 0, 9]",
         "w.toml:7:10: a sphere has no turned. it has centre, diameter; turned is of a box"},
        {"[[motion.obstacle]]\nkind = \"capsule\"\nheight = 2",
         "w.toml:7:10: a capsule has no height. it has centre, diameter, length, turned; height is of a cylinder"},
        {"[[motion.obstacle]]\nkind = \"box\"\ndegrees = 30\nturned = [9, 0, 0]",
         "w.toml:7:11: a box is turned by degrees about z, and by turned. take degrees out; turned = [0, 0, 30] is the same"},
        {"[[motion.obstacle]]\nkind = \"box\"\nturned = [9e6, 0, 0]", "w.toml:7:10: an obstacle is turned by more than a million degrees"},
        {"[[motion.obstacle]]\nkind = \"cylinder\"\nheight = 0.5\nrounding = 0.3",
         "w.toml:8:12: edges rounded by 0.3 leave nothing of the cylinder. write less than half of its least edge, 0.25"},
        {"[[motion.obstacle]]\nkind = \"hok\"\n[[motion.compound]]\nname = \"hook\"\n[[motion.compound.part]]\nshape = \"cube\"",
         "w.toml:6:8: [[motion.obstacle]] kind = \"hok\" does not exist. did you mean 'hook'?"},
        {"[[motion.obstacle]]\nkind = \"hook\"\nsize = [1, 1, 1]\n[[motion.compound]]\nname = \"hook\"\n[[motion.compound.part]]\n"
         "shape = \"cube\"",
         "w.toml:7:8: a compound has no size. it has centre, turned; size is of a box"},
        {"[[motion.obstacle]]\nkind = \"terrain\"\noffset = 1",
         "w.toml:7:10: a terrain has no offset. it has centre, cell, heights; offset is of a plane"},
        {"[[motion.feature]]\nkind = \"latch\"\ndirections = 6\ndepth = 0.1",
         "w.toml:8:9: a latch has no depth. it has strength; depth is of a dipole"},
        {"[[motion.feature]]\ndirections = 6\narea = 0.1", "w.toml:7:8: a dipole has no area. it has strength, depth; area is of a plate"},
        {"[[motion.feature]]\nkind = \"plate\"\ndirections = 6\ncurrent = 1",
         "w.toml:8:11: this is a coil's, and the feature is of the kind plate. current is of magnets; plates have a voltage"},
        {"[[motion.feature]]\nkind = \"electrode\"\ndirections = 6\ndepth = 1",
         "w.toml:8:9: an electrode has no depth. it has strength, area, cover, permittivity; depth is of a dipole"},
        {"[[motion.feature]]\ndirections = 6\nresistance = 1",
         "w.toml:7:14: a magnet with resistance needs current too. give the magnet a current, or take resistance out"},
        {"[[motion.feature]]\ndirections = 6\ncurrent = 1\nresistance = 1\nthermal_resistance = 1",
         "w.toml:9:22: a magnet with thermal_resistance needs cooling too. give the magnet a cooling, or take thermal_resistance out"},
        {"[[motion.feature]]\ndirections = 6\ncurrent = 1\nresistance = 1\nthermal_resistance = 1\ncooling = 1\nhottest = 60",
         "w.toml:11:11: the limit of 60 K is not above the 293.15 K around the coil. give both in kelvins"},
        {"[[motion.catoms]]\nwhere = \"id ==\"", "w.toml:6:15: expected a number, found the end"},
        {"[time]\ntick = \"1ms\"", "w.toml:5:1: a tick of this world lasts [motion] step times steps. take [time] out"},
        {"[target]\nshape = \"box(1, 1, 1)\"\ncells = 3",
         "w.toml:5:1: a target with a given number of cells needs a lattice. take [target] cells out"},
    };
    for (const auto& [line, message] : wrong) {
        const std::string found = error_of(kFree + line + "\n");
        EXPECT_TRUE(found.starts_with(message)) << line << "\n" << found;
    }
    EXPECT_EQ(error_of("held = 1\n" + kFree), "w.toml:1:8: catoms hold units only where they stand on a lattice. take held out");
    EXPECT_EQ(
        error_of("[[body]]\npositions = [[0, 0, 0]]\n"),
        "w.toml:1:1: a [[body]] has positions, and catoms stand on cells here. give it cells, or the world [motion] kind = \"bodies\"");
    EXPECT_EQ(error_of("[[body]]\npositions = [[0, 0]]\n[motion]\nkind = \"bodies\"\n"),
              "w.toml:2:14: an item of [[body]] positions is not a point [x, y, z] of three finite numbers");
}

std::string error_of_list(const std::string& text) {
    std::vector<PlacedCatom> placed;
    const Result<void> added = add_positions(text, "p.csv", placed);
    return added ? "" : added.error().message();
}

TEST(PositionsFile, HasColumnsThatItsFirstLineNames) {
    std::vector<PlacedCatom> placed;
    ASSERT_TRUE(add_positions("# made by hand\nx, y, z, mass, radius\n1, 2, 3, 7, 0.25\n\n-1,0,0.5,8,1\n", "p.csv", placed));
    ASSERT_TRUE(add_positions("4,5,6\n", "q.csv", placed));
    ASSERT_TRUE(add_positions("places\n7,8,9\n", "r.csv", placed));
    std::vector<PlacedCatom> quoted;
    ASSERT_TRUE(add_positions("\"x\",\"y\",\"z\",\"mass\"\n\"1\", \"2\",3,\"4\"\n", "s.csv", quoted));
    EXPECT_EQ(quoted.at(0).position, (Vec3{1, 2, 3}));
    EXPECT_EQ(quoted.at(0).mass, 4);
    ASSERT_EQ(placed.size(), 4u);
    EXPECT_EQ(placed[1].position, (Vec3{-1, 0, 0.5}));
    EXPECT_EQ(placed[1].radius, 1);
    EXPECT_EQ(placed[1].mass, 8);
    EXPECT_EQ(placed[0].radius, 0.25);
    EXPECT_EQ(placed[2].position, (Vec3{4, 5, 6}));
    EXPECT_FALSE(placed[2].radius);
    EXPECT_FALSE(placed[3].mass);
}

TEST(PositionsFile, SaysWhatIsWrongAndWhere) {
    EXPECT_EQ(error_of_list("x,y,z,radios\n"), "p.csv:1:7: a list of positions has no column 'radios'. did you mean 'radius'?");
    EXPECT_EQ(error_of_list("x,y,z,radius\n1,2,3,0\n"), "p.csv:2:7: 0 is not a number above zero");
    EXPECT_EQ(error_of_list("x,y,z,radius\n1,2,3,wide\n"), "p.csv:2:7: 'wide' is not a number");
    EXPECT_EQ(error_of_list("x,y,z,radius\n1,2,3\n"), "p.csv:2: here are 3 numbers, and the first line names 4 columns");
    EXPECT_EQ(error_of_list("1,2,3,4\n"), "p.csv:1: a position has 3 coordinates, here are 4");
    EXPECT_EQ(error_of_list("1,2,3\n1,\"2\"\"\",3\n"), "p.csv:2:4: '2\"' is not a coordinate. write numbers, x,y,z");
    for (const auto& [text, message] : {std::pair("1,2,3\n1,\"2,3\n", "p.csv:2:3: this quote is not closed. end the field"),
                                        std::pair("x,y,z,\"mass\n1,2,3,4\n", "p.csv:1:7: this quote is not closed. end the field"),
                                        std::pair("1,2,\"3\"4\n", "p.csv:1:8: text follows the quote that ends a field. write"),
                                        std::pair("1,2,3\"\n", "p.csv:1:6: a quote inside a field that does not begin with one. put")})
        EXPECT_EQ(error_of_list(text).rfind(message, 0), 0u) << error_of_list(text);
    EXPECT_EQ(error_of_list("1,b,3\n"), "p.csv:1:3: 'b' is not a coordinate. write numbers, x,y,z");
}

}  // namespace
}  // namespace meld::world
