#include <gtest/gtest.h>

#include "runtime/world/file/world_file.h"

namespace meld::world {
namespace {

const std::string kTwo = "[[body]]\npositions = [[0, 0, 0], [1, 0, 0]]\n[motion]\nkind = \"bodies\"\n";

std::string outcome_of(const std::string& joint) {
    const Result<World> world = parse_world(kTwo + joint, "w.toml");
    return world ? "fine" : world.error().message();
}

TEST(JointSection, ReadsEachKey) {
    const Result<World> world = parse_world(kTwo + R"toml(
[[motion.joint]]
kind = "slider"
between = [1, 0]
axis = [0, 2, 0]
limits = [-inf, 3]
force = 12
speed = 0.5
response = "20ms"
servo = 2
breaking_force = 300
[[motion.joint]]
where = "id < 2"
stiffness = 4
damping = 0.5
rest = -30
[[motion.joint]]
kind = "ball"
between = [0, 1]
anchor = [0.5, 0, 1]
breaking_torque = 20
)toml",
                                            "w.toml");
    ASSERT_TRUE(world) << world.error().message();
    ASSERT_EQ(world->physics.joints.size(), 3u);
    const JointOptions &slider = world->physics.joints[0], &spring = world->physics.joints[1], &ball = world->physics.joints[2];
    EXPECT_EQ(slider.kind, "slider");
    EXPECT_EQ(slider.between, (std::array<std::uint64_t, 2>{1, 0}));
    EXPECT_EQ(slider.breaking_force, 300);
    EXPECT_FALSE(slider.breaking_torque);
    EXPECT_EQ(slider.axis, (Vec3{0, 2, 0}));
    EXPECT_EQ((*slider.limits)[1], 3);
    EXPECT_EQ(slider.strength, 12);
    EXPECT_EQ(slider.speed, 0.5);
    EXPECT_EQ(slider.response, 0.02);
    EXPECT_EQ(slider.drive, "servo");
    EXPECT_EQ(slider.target, 2);
    EXPECT_EQ(spring.kind, "hinge");
    EXPECT_FALSE(spring.between);
    EXPECT_EQ(spring.where.text(), "id < 2");
    EXPECT_EQ(spring.stiffness, 4);
    EXPECT_EQ(spring.damping, 0.5);
    EXPECT_EQ(spring.rest, -30);
    EXPECT_EQ(spring.drive, "coast");
    EXPECT_EQ(ball.anchor, (Vec3{0.5, 0, 1}));
    EXPECT_EQ(ball.breaking_torque, 20);
    EXPECT_EQ(spring.place, "w.toml:16:1");
}

TEST(JointSection, SaysWhatIsWrong) {
    const std::pair<std::string, std::string> wrong[] = {
        {"", "needs either two catoms or a region"},
        {"between = [0, 1]\nwhere = \"all\"", "needs either two catoms or a region"},
        {"between = [0, 0]", "a joint is not between two catoms"},
        {"between = [0, -1]", "a joint is not between two catoms"},
        {"between = [0]", "a joint is not between two catoms"},
        {"where = \"all\"\nanchor = [0, 0, 0]", "one anchor cannot be that of several joints"},
        {"between = [0, 1]\nkind = \"weld\"", "does not exist"},
        {"between = [0, 1]\nanchor = [1e300, 0, 0]", "the anchor of a joint is too far away"},
        {"between = [0, 1]\naxis = [0, 0, 0]", "the axis of a joint has no direction"},
        {"between = [0, 1]\nlimits = [1, 2]", "the limits of a joint are not around 0"},
        {"between = [0, 1]\nlimits = 3", "the limits of a joint are not around 0"},
        {"between = [0, 1]\nforce = 3", "a hinge has no force"},
        {"between = [0, 1]\nkind = \"slider\"\ntorque = 3", "a slider has no torque"},
        {"between = [0, 1]\nmotor = 3", "a joint without torque has no motor"},
        {"between = [0, 1]\nkind = \"slider\"\nbrake = true", "a joint without force has no motor"},
        {"between = [0, 1]\ntorque = 3\nmotor = 3\nbrake = true", "a joint does two things at the start"},
        {"between = [0, 1]\ntorque = 3\nstiffness = 1", "a joint has a spring or a motor"},
        {"between = [0, 1]\nrest = 3", "a joint without stiffness has no spring"},
        {"between = [0, 1]\nkind = \"ball\"\nlimits = [-1, 1]", "a ball has no limits"},
        {"between = [0, 1]\nkind = \"slider\"\nanchor = [0, 0, 0]", "a slider has no anchor"},
        {"between = [0, 1]\nbreaking_force = 0", "breaking_force"},
        {"between = [0, 1]\nkind = \"ball\"\nbreaking_torque = -1", "breaking_torque"},
    };
    for (const auto& [keys, message] : wrong)
        EXPECT_NE(outcome_of("[[motion.joint]]\n" + keys + "\n").find(message), std::string::npos)
            << keys << "\n"
            << outcome_of("[[motion.joint]]\n" + keys + "\n");
    EXPECT_NE(outcome_of("engine = \"hash\"\n[[motion.joint]]\nbetween = [0, 1]\n").find("the engine \"hash\" has no joints"),
              std::string::npos);
    EXPECT_EQ(outcome_of("[[motion.joint]]\nbetween = [0, 1]\n"), "fine");
}

TEST(JointSection, ReadsKindsOfJointsThatProgramsMake) {
    const Result<World> world = parse_world(
        kTwo +
            "[[motion.joint_kind]]\nanchor = [0.5, 0, 0]\naxis = [0, 1, 0]\ntorque = 3\nservo = 20\nreach = 0.2\n[[motion.joint_kind]]\n"
            "kind = \"ball\"\n",
        "w.toml");
    ASSERT_TRUE(world) << world.error().message();
    ASSERT_EQ(world->physics.joint_kinds.size(), 2u);
    const JointOptions &hinge = world->physics.joint_kinds[0], &ball = world->physics.joint_kinds[1];
    EXPECT_EQ(hinge.anchor, (Vec3{0.5, 0, 0}));
    EXPECT_EQ(hinge.axis, (Vec3{0, 1, 0}));
    EXPECT_EQ(hinge.reach, 0.2);
    EXPECT_EQ(hinge.drive, "servo");
    EXPECT_EQ(ball.kind, "ball");
    EXPECT_EQ(ball.reach, 0.05);
    EXPECT_TRUE(world->physics.joints.empty() && world->physics.has_joints());
}

TEST(JointSection, SaysWhatIsWrongWithKinds) {
    const auto said = [](const std::string& lines) { return outcome_of(lines); };
    const std::string kind = "[[motion.joint_kind]]\n";
    EXPECT_NE(said(kind + "between = [0, 1]\n").find("there is no key 'between' in [[motion.joint_kind]]"), std::string::npos);
    EXPECT_NE(said(kind + "reach = -1\n").find("reach"), std::string::npos);
    EXPECT_NE(said(kind + "limits = [1, 2]\n").find("the limits of a joint are not around 0"), std::string::npos);
    EXPECT_NE(said("[[motion.joint]]\nbetween = [0, 1]\nreach = 1\n").find("there is no key 'reach' in [[motion.joint]]"),
              std::string::npos);
    EXPECT_NE(said("engine = \"hash\"\n" + kind).find("the engine \"hash\" has no joints"), std::string::npos);
    EXPECT_NE(said("engine = \"ode\"\n" + kind).find("the engine \"ode\" makes no joints later"), std::string::npos);
    EXPECT_EQ(said(kind), "fine");
}

TEST(JointSection, TakesTheDirectionOfAnyAxis) {
    for (const char* axis : {"[0, 1e300, 0]", "[0, 1e-200, 0]"}) {
        const Result<World> world = parse_world(kTwo + "[[motion.joint]]\nbetween = [0, 1]\naxis = " + axis + "\n", "w.toml");
        ASSERT_TRUE(world) << world.error().message();
        EXPECT_EQ(world->physics.joints[0].axis, (Vec3{0, 1, 0})) << axis;
    }
}

}  // namespace
}  // namespace meld::world
