#include <gtest/gtest.h>

#include <string>

#include "runtime/world/description/compounds.h"
#include "runtime/world/file/world_file.h"

namespace meld::world {
namespace {

const std::string kDumbbell = R"toml([[body]]
positions = [[0, 0, 0], [3, 0, 0]]
[motion]
kind = "bodies"
[[motion.compound]]
name = "dumbbell"
[[motion.compound.part]]
shape = "sphere"
diameter = 0.8
at = [1, 0, 0]
[[motion.compound.part]]
shape = "capsule"
diameter = 0.2
length = 2
at = [2, 0, 0]
turned = [0, 90, 0]
[[motion.compound.part]]
shape = "sphere"
diameter = 0.8
at = [3, 0, 0]
)toml";

std::string problem_of_forms(const std::string& text) {
    const Result<World> world = parse_world(text, "w.toml");
    return world ? "fine" : world.error().message();
}

TEST(FormSection, ReadsCompounds) {
    const Result<World> world = parse_world(kDumbbell + "[[motion.catoms]]\nwhere = \"id == 1\"\nshape = \"dumbbell\"\n", "w.toml");
    ASSERT_TRUE(world) << world.error().message();
    EXPECT_TRUE(world->physics.has_forms());
    EXPECT_EQ(world->physics.groups[0].form->compound, 0u);
    const physics::BodyShape shape = compounds_of(world->physics, 2).at(0);
    ASSERT_EQ(shape.parts.size(), 3u);
    // In metres from the centre of mass, where catoms have two metres.
    EXPECT_NEAR(shape.parts[0].at_m.x, -2, 1e-12);
    EXPECT_NEAR(shape.parts[1].at_m.x, 0, 1e-12);
    EXPECT_NEAR(shape.parts[0].rounding_m, 0.8, 1e-12);
    EXPECT_NEAR(shape.parts[1].core_m.z, 1.8, 1e-12);
    EXPECT_NEAR(shape.radius_m(), 2.8, 1e-12);
    EXPECT_NEAR(shape.least_m(), 0.2, 1e-12);
    const RoundedBody look = look_of(shape, {}, 2);
    EXPECT_EQ(look.compound(), 0u);
    EXPECT_NEAR(look.core[0], 1.4, 1e-12);
    // The step follows the thinnest part.
    EXPECT_LT(world->physics.step, 0.6 / 240);
}

TEST(FormSection, RefusesWhatIsNoCompound) {
    const std::string catoms = "[[motion.catoms]]\nwhere = \"all\"\n";
    for (const auto& [more, message] :
         {std::pair<std::string, const char*>{catoms + "shape = \"dumbbel\"\n", "did you mean 'dumbbell'"},
          {catoms + "shape = \"dumbbell\"\nradius = 1\n", "the size of a dumbbell is that of its parts"},
          {catoms + "shape = \"dumbbell\"\ninertia = 0.4\n", "the inertia of a dumbbell follows from its shape"},
          {catoms + "shape = \"dumbbell\"\nlength = 2\n", "length has no effect on the compound dumbbell"},
          {"[[motion.compound]]\nname = \"dumbbell\"\n", "there are two compounds dumbbell"},
          {"[[motion.compound]]\nname = \"cube\"\n", "cube is the name of a solid"},
          {"[[motion.compound]]\n", "has no name"},
          {"[[motion.compound]]\nname = \"none\"\n", "the compound none has no parts"},
          {"[[motion.compound.part]]\nshape = \"dumbbell\"\n", "does not exist"},
          {"[[motion.compound.part]]\nshape = \"cube\"\nshare = 2\n", "some parts of the compound dumbbell have a share"},
          {"[[motion.compound.part]]\nshape = \"box\"\nedges = [1, 1, 1]\ndiameter = 2\n", "a box has edges and no diameter"},
          {"[[motion.compound.part]]\nshape = \"sphere\"\nat = [1e7, 0, 0]\n", "more than a million diameters away"},
          {"[[motion.compound.part]]\nshape = \"sphere\"\nat = [1e5, 0, 0]\n", "the compound dumbbell cannot be"}})
        EXPECT_NE(problem_of_forms(kDumbbell + more).find(message), std::string::npos) << more << problem_of_forms(kDumbbell + more);
    const auto with = [&](const std::string& key) {
        std::string text = kDumbbell;
        return problem_of_forms(text.replace(text.find("kind"), 0, key + "\nshape = \"dumbbell\"\n"));
    };
    EXPECT_NE(with("engine = \"hash\"").find("the engine \"hash\" knows spheres alone"), std::string::npos) << with("engine = \"hash\"");
    EXPECT_EQ(with("engine = \"ode\""), "fine");
}

}  // namespace
}  // namespace meld::world
