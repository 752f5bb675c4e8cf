#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/unit/runtime_world/parsed_world.h"

namespace meld::world {
namespace {

const std::string kOfBodies = "[motion]\nkind = \"bodies\"\n";
// A hull, a wheel beside it on a hinge, and a box that is held behind it.
const std::string kCart = R"toml([[assembly]]
name = "cart"
connections = [["box", "hull"]]
[[assembly.part]]
name = "hull"
mass = 3
[[assembly.part]]
name = "wheel"
at = [0, 1, 0]
turned = [90, 0, 0]
shape = "cylinder"
height = 0.5
[[assembly.part]]
name = "box"
at = [-1, 0, 0]
[[assembly.joint]]
between = ["hull", "wheel"]
anchor = [0, 0.5, 0]
axis = [0, 1, 0]
torque = 2
)toml";

std::string carts(const std::string& keys) { return "[[body]]\nassembly = \"cart\"\n" + keys; }

void expect_near(const Vec3& found, const Vec3& wanted) {
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[i], wanted[i], 1e-12) << i;
}

TEST(AssemblySection, NumbersThePartsOfEachRobotInTheirOrder) {
    const World world = world_of(kCart + carts("positions = [[5, 0, 0], [9, 0, 1]]\n") + kOfBodies);
    ASSERT_EQ(world.placed.size(), 6u);
    EXPECT_EQ(world.placed[0].position, (Vec3{5, 0, 0}));
    EXPECT_EQ(world.placed[1].position, (Vec3{5, 1, 0}));
    EXPECT_EQ(world.placed[5].position, (Vec3{8, 0, 1}));
    ASSERT_TRUE(world.robots);
    EXPECT_EQ(world.robots->count(), 2u);
    const RobotPart box = *world.robots->of(5);
    EXPECT_EQ(box.robot, 1u);
    EXPECT_EQ(box.part, 2u);
    EXPECT_EQ(box.first_catom, 3u);
    EXPECT_EQ(world.robots->turn_of(box), nullptr);
    EXPECT_FALSE(world.robots->of(6));
    EXPECT_TRUE(world.robots->assemblies()[0].connects(2, 0));
    EXPECT_FALSE(world.robots->assemblies()[0].connects(1));
}

TEST(AssemblySection, CountsFromTheCatomsOnCellsOn) {
    const World world = world_of("[[body]]\nshape = \"box(3, 2, 1)\"\n[[body]]\npositions = [[0, 0, 9], [2, 0, 9]]\n" + kCart +
                                 carts("positions = [[0, 20, 0]]\n") + "[without]\ncells = [[0, 0, 0]]\n" + kOfBodies);
    // Five on cells and two listed ones come before.
    EXPECT_FALSE(world.robots->of(6));
    EXPECT_EQ(world.robots->of(7)->part, 0u);
    EXPECT_EQ(world.robots->of(9)->first_catom, 7u);
    EXPECT_FALSE(world.robots->of(10));
    EXPECT_EQ(world.physics.joints[0].between, (std::array<std::uint64_t, 2>{7, 8}));
}

TEST(AssemblySection, TurnsRobotsWithTheirPartsAndJoints) {
    const World world = world_of(kCart + carts("positions = [[5, 0, 0], [9, 0, 0]]\nturned = [[0, 0, 90], [0, 0, 0]]\n") + kOfBodies);
    expect_near(world.placed[1].position, {4, 0, 0});
    expect_near(world.placed[2].position, {5, -1, 0});
    EXPECT_EQ(world.placed[4].position, (Vec3{9, 1, 0}));
    ASSERT_EQ(world.physics.joints.size(), 2u);
    expect_near(*world.physics.joints[0].anchor, {4.5, 0, 0});
    expect_near(world.physics.joints[0].axis, {-1, 0, 0});
    EXPECT_EQ(world.physics.joints[1].between, (std::array<std::uint64_t, 2>{3, 4}));
    EXPECT_EQ(world.physics.joints[1].axis, (Vec3{0, 1, 0}));
    const Turn& turn = *world.robots->turn_of(*world.robots->of(0));
    EXPECT_NEAR(turn[0], turn[3], 1e-12);
    EXPECT_EQ(*world.robots->turn_of(*world.robots->of(3)), (Turn{1, 0, 0, 0}));
}

TEST(AssemblySection, PlacesRobotsInShapesAndAtCells) {
    const World world = world_of(kCart + carts("shape = \"move(box(2, 2, 1), 0.5, 0.5)\"\nspacing = 4\nturned = [0, 0, 180]\n") +
                                 carts("cells = [[9, 9, 2]]\nspacing = 3\n") + kOfBodies);
    EXPECT_EQ(world.robots->count(), 5u);
    EXPECT_EQ(world.placed[12].position, (Vec3{27, 27, 6}));
    EXPECT_EQ(world.robots->of(12)->robot, 4u);
    for (std::size_t robot = 0; robot < 4; ++robot)
        for (const double x : world.placed[3 * robot].position) EXPECT_TRUE(x == 0 || x == 4) << x;
}

TEST(AssemblySection, ReadsPlacesFromFiles) {
    const WorldFiles files = {{"plain.csv", "1,2,3\n"}, {"turned.csv", "x,y,z,turned_z\n7,0,0,90\n20,0,0,0\n"}};
    const std::string text = kCart + carts("positions = \"plain.csv\"\n") + carts("positions = \"turned.csv\"\n") + kOfBodies;
    const Result<World> world = parse_world(text, "w.toml", &files);
    ASSERT_TRUE(world) << world.error().message();
    EXPECT_EQ(world->robots->count(), 3u);
    EXPECT_EQ(world->placed[0].position, (Vec3{1, 2, 3}));
    expect_near(world->placed[4].position, {6, 0, 0});
    const WorldFiles wrong = {{"plain.csv", "1,2,3\n"}, {"turned.csv", "x,y,z,radius\n7,0,0,1\n"}};
    EXPECT_NE(
        parse_world(text, "w.toml", &wrong).error().message().find("turned.csv:1:7: a list of places of robots has no column 'radius'"),
        std::string::npos);
}

TEST(AssemblySection, GivesBodiesTheKeysOfTheirParts) {
    const World world = world_of(kCart + carts("positions = [[0, 0, 0], [9, 0, 0]]\n") + kOfBodies +
                                 "[[motion.catoms]]\nwhere = \"part == box\"\nmass = 7\n");
    const std::vector<CatomGroup>& groups = world.physics.groups;
    // Those of the world come last, and override those of parts.
    ASSERT_EQ(groups.size(), 4u);
    EXPECT_EQ(groups[0].mass, 3);
    EXPECT_EQ(groups[1].form->kind, "cylinder");
    EXPECT_EQ(groups[1].turned, (Vec3{90, 0, 0}));
    EXPECT_EQ(groups[3].mass, 7);
    EXPECT_EQ(groups[1].place, "w.toml:7:1");
    for (std::uint64_t id = 0; id < 6; ++id)
        for (std::size_t part = 0; part < 3; ++part) EXPECT_EQ(groups[part].where.contains(id, {}, {}), id % 3 == part) << id;
}

TEST(AssemblySection, LetsRegionsNameRobots) {
    const std::string other = "[[assembly]]\nname = \"ball\"\n[[assembly.part]]\nname = \"hull\"\n";
    const auto chosen = [&](const std::string& region) {
        const World world =
            world_of("[[body]]\npositions = [[0, 0, 50]]\n" + kCart + other + carts("positions = [[0, 0, 0], [9, 0, 0]]\n") +
                     "[[body]]\nassembly = \"ball\"\npositions = [[0, 9, 0]]\n" + kOfBodies + "[facts]\nf = \"" + region + "\"\n");
        std::string found;
        for (std::uint64_t id = 0; !world.facts.empty() && id < 9; ++id)
            if (world.facts[0].where.contains(id, {}, {})) found += std::to_string(id);
        return found;
    };
    EXPECT_EQ(chosen("part == hull"), "147");
    EXPECT_EQ(chosen("part == 'hull'"), "147");
    EXPECT_EQ(chosen("part != hull"), "2356");
    EXPECT_EQ(chosen("!(part == hull)"), "023568");
    EXPECT_EQ(chosen("assembly == ball"), "7");
    EXPECT_EQ(chosen("assembly != ball && part == hull"), "14");
    EXPECT_EQ(chosen("robot == 1"), "456");
    EXPECT_EQ(chosen("robot % 2 == 0"), "1237");
    EXPECT_EQ(chosen("robot >= 0"), "1234567");
}

TEST(AssemblySection, SaysWhatIsWrong) {
    const std::string start = "[[body]]\nassembly = \"a\"\npositions = [[0, 0, 0]]\n" + kOfBodies;
    const std::string a = "[[assembly]]\nname = \"a\"\n",
                      two = "[[assembly.part]]\nname = \"p\"\n[[assembly.part]]\nname = \"q\"\nat = [1, 0, 0]\n";
    const std::string joint = "[[assembly.joint]]\n";
    const std::pair<std::string, std::string> wrong[] = {
        {"[[assembly]]\n" + two, "an [[assembly]] has no name"},
        {"[[assembly]]\nname = \"two wheels\"\n" + two, "'two wheels' is no word"},
        {a, "the assembly a has no parts"},
        {a + "[[assembly.part]]\nat = [0, 0, 0]\n", "an [[assembly.part]] has no name"},
        {a + "[[assembly.part]]\nname = \"3rd\"\n", "'3rd' is no word"},
        {a + two + "[[assembly.part]]\nname = \"p\"\n", "the assembly a has two parts p"},
        {a + two + a + two, "there are two assemblies a"},
        {a + two + "where = \"all\"\n", "there is no key 'where' in [[assembly.part]]"},
        {a + "[[assembly.part]]\nname = \"p\"\nat = [1e9, 0, 0]\n", "more than a million diameters away"},
        {a + two + joint, "an [[assembly.joint]] is between no parts"},
        {a + two + joint + "between = [0, 1]\n", "these are not two parts"},
        {a + two + joint + "between = [\"p\"]\n", "these are not two parts"},
        {a + two + joint + "between = [\"p\", \"qq\"]\n", "the assembly a has no part 'qq'. one of p, q"},
        {a + two + joint + "between = [\"p\", \"p\"]\n", "the part p is named twice"},
        {a + two + joint + "between = [\"p\", \"q\"]\n" + joint + "between = [\"q\", \"p\"]\n", "q and p have two joints"},
        {a + two + joint + "between = [\"p\", \"q\"]\nforce = 3\n", "a hinge has no force"},
        {a + "connections = [[\"p\", \"q\"]]\n" + two + joint + "between = [\"p\", \"q\"]\n", "p and q have a joint, and are connected"},
        {a + "connections = [[\"p\", \"r\"]]\n" + two, "the assembly a has no part 'r'"},
        {a + "connections = \"all\"\n" + two, "an array of pairs of parts"},
        {"", "there is no assembly 'a'. describe it by [[assembly]]"},
        {"[[assembly]]\nname = \"aa\"\n" + two, "there is no assembly 'a'. one of aa"},
        {"assembly = 3\n", "assembly is an integer, not tables [[assembly]]"},
    };
    for (const auto& [text, message] : wrong)
        EXPECT_NE(error_of(text + start).find(message), std::string::npos) << text << error_of(text + start);
    EXPECT_EQ(error_of(a + two + start), "fine");
}

TEST(AssemblySection, SaysWhatIsWrongWithPlacesAndRegions) {
    const std::pair<std::string, std::string> wrong[] = {
        {carts(""), "has neither shape nor cells"},
        {carts("positions = []\n"), "no robot stands here"},
        {carts("positions = [[0, 0, 0]]\nspacing = 2\n"), "robots at positions have no spacing"},
        {carts("positions = [[0, 0, 0]]\nturned = [[0, 0, 1], [0, 0, 2]]\n"), "robots here: 1; vectors that turn them: 2"},
        {carts("positions = [[0, 0, 0]]\nturned = [0, 0, 1e9]\n"), "turned by more than a million degrees"},
        {carts("shape = \"box(1e5, 1e5, 1)\"\n"), "robots are too many"},
        {"[[body]]\npositions = [[0, 0, 0]]\nturned = [0, 0, 90]\n", "has turned, which is of robots, and no assembly"},
        {"[[body]]\nshape = \"box(1, 1, 1)\"\nspacing = 2\n", "has spacing, which is of robots, and no assembly"},
        {carts("positions = [[0, 0, 0]]\n") + "[facts]\nf = \"part == whel\"\n", "no assembly has a part 'whel'. did you mean 'wheel'?"},
        {carts("positions = [[0, 0, 0]]\n") + "[facts]\nf = \"part = wheel\"\n", "expected '==' or '!=', found '='. write =="},
        {carts("positions = [[0, 0, 0]]\n") + "[facts]\nf = \"part == 3\"\n", "expected a name, as in part == left"},
        {carts("positions = [[0, 0, 0]]\n") + "[facts]\nf = \"assembly == car\"\n", "there is no assembly 'car'. did you mean 'cart'?"},
        {carts("positions = [[0, 0, 0]]\n") + "[facts]\nf = \"robot == hull\"\n", "expected a number"},
    };
    for (const auto& [text, message] : wrong)
        EXPECT_NE(error_of(kCart + text + kOfBodies).find(message), std::string::npos) << text << error_of(kCart + text + kOfBodies);
    EXPECT_NE(error_of("[[body]]\nshape = \"box(1, 1, 1)\"\n[facts]\nf = \"part == hull\"\n").find("this world has no robots"),
              std::string::npos);
    EXPECT_NE(error_of(kCart + "[[body]]\nshape = \"box(1, 1, 1)\"\n").find("robots consist of bodies, and this world has none"),
              std::string::npos);
    // A kind of which there is none is probably a mistake.
    const World without = world_of(kCart + "[[body]]\npositions = [[0, 0, 0]]\n" + kOfBodies);
    ASSERT_EQ(without.warnings.size(), 1u);
    EXPECT_NE(without.warnings[0].find("no robot is a cart"), std::string::npos);
    EXPECT_TRUE(without.physics.groups.empty() && without.physics.joints.empty());
}

}  // namespace
}  // namespace meld::world
