// Joints of bodies that are parts of composites, against mechanics, and in a world divided among parts.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/unit/physics/divided_world.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics {
namespace {

constexpr double kHalfTurn = std::numbers::pi;
constexpr double kCube_m = 0.2;

Settings without_sleep(Vec3 gravity = {0, 0, -kGravity}) { return settings_with(gravity, 0); }

double whole_energy(const Scene& scene) { return scene.kinetic_energy_j() + scene.potential_energy_j(); }

// A rod of connected cubes of 1 kg, numbered from 1, that begins at a hinge about y on a fixed body, and leads away from it in this
// direction of the plane y = 0.
std::unique_ptr<Scene> rod_on_a_hinge(BodyId cubes, double angle_from_x, JointSpec joint = {}) {
    auto scene = make_scene(without_sleep());
    const Vec3 pivot{0, 0, 5}, along{std::cos(angle_from_x), 0, std::sin(angle_from_x)};
    need(scene->add_body({.id = 0, .position_m = pivot, .radius_m = 0.01, .fixed = true}));
    for (BodyId i = 1; i <= cubes; ++i) {
        need(scene->add_body({.id = i,
                              .position_m = pivot + (kCube_m * (i - 0.5)) * along,
                              .orientation = turn_of(-angle_from_x, {0, 1, 0}),
                              .shape = box_shape({kCube_m, kCube_m, kCube_m}, 0.001)}));
        if (i > 1) need(scene->connect(i - 1, i));
    }
    joint.first = 0, joint.second = 1, joint.anchor_m = pivot, joint.axis = {0, 1, 0};
    need(scene->add_joint(joint));
    return scene;
}

// Of such a rod about its hinge; of cubes with edges that are a little rounded.
double moment_about_hinge(BodyId cubes) {
    double sum = 0;
    for (BodyId i = 1; i <= cubes; ++i) {
        const double arm = kCube_m * (i - 0.5);
        sum += box_shape({kCube_m, kCube_m, kCube_m}, 0.001).inertia_per_kg_m2().y + arm * arm;
    }
    return sum;
}

TEST(JoinedComposites, ARodSwingsInTheTimeOfItsMomentOfInertia) {
    constexpr BodyId kCubes = 5;
    const double tilt = 5 * kHalfTurn / 180;
    auto scene = rod_on_a_hinge(kCubes, -kHalfTurn / 2 + tilt);
    Workers workers(1);
    std::vector<double> crossings;
    double before = scene->state(kCubes).position_m.x;
    for (int tick = 1; tick <= 2400; ++tick) {
        run(*scene, 1, 2, workers);
        const double now = scene->state(kCubes).position_m.x;
        if (before < 0 && now >= 0) crossings.push_back((tick - now / (now - before)) * kTick);
        before = now;
    }
    ASSERT_GE(crossings.size(), 4u);
    const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
    const double centre = 0.5 * kCubes * kCube_m;
    const double exact = 2 * kHalfTurn * std::sqrt(moment_about_hinge(kCubes) / (kCubes * kGravity * centre)) * (1 + tilt * tilt / 16);
    EXPECT_NEAR(period, exact, 0.002 * exact);
}

TEST(JoinedComposites, ARodThatFallsFromLevelComesBackAsHighAndStaysOnItsHinge) {
    auto scene = rod_on_a_hinge(5, 0);
    Workers workers(1);
    const double start = whole_energy(*scene);
    double worst = 0, highest = 0, off = 0;
    for (int tick = 0; tick < 2400; ++tick) {
        run(*scene, 1, 2, workers);
        worst = std::max(worst, std::abs(whole_energy(*scene) - start));
        const BodyState one = scene->state(1);
        off = std::max(off, length(one.position_m + rotate(one.orientation, {-0.5 * kCube_m, 0, 0}) - Vec3{0, 0, 5}));
        if (tick > 1200) highest = std::max(highest, scene->state(5).position_m.z);
    }
    EXPECT_LT(worst, 0.01 * 5 * kGravity * 0.5);
    EXPECT_LT(off, 1e-6);
    EXPECT_GT(highest, 5 - 0.01);
}

TEST(JoinedComposites, AMotorLiftsAnArmIfItsTorqueIsMoreThanThatOfTheWeight) {
    const double weight_nm = 5 * kGravity * 0.5;
    for (const auto& [torque, rises] : {std::pair{1.05 * weight_nm, true}, {0.95 * weight_nm, false}}) {
        // Up is a negative angle about y.
        auto scene = rod_on_a_hinge(5, 0, {.strength = torque, .drive = {JointDrive::Kind::Motor, -0.5}});
        Workers workers(1);
        run(*scene, 24, 2, workers);
        // 0.1 s with the torque that is left over.
        const double exact = (torque - weight_nm) / moment_about_hinge(5) * 24 * kTick;
        EXPECT_NEAR(-scene->joint(0, 1)->speed, exact, 0.02 * std::abs(exact));
        EXPECT_EQ(scene->state(5).position_m.z > 5, rises);
    }
}

TEST(JoinedComposites, ConnectionsOfAnArmThatIsHeldCarryItsWeight) {
    auto scene = rod_on_a_hinge(5, 0, {.strength = 100, .drive = {JointDrive::Kind::Brake, 0}});
    scene->want_loads();
    Workers workers(1);
    run(*scene, 240, 2, workers);
    need(scene->solve_loads(workers));
    run(*scene, 1, 2, workers);
    need(scene->solve_loads(workers));
    EXPECT_NEAR(scene->joint_load(0, 1)->torque_nm, 5 * kGravity * 0.5, 0.001 * 5 * kGravity);
    EXPECT_NEAR(scene->joint_load(0, 1)->force_n(), 5 * kGravity, 0.001 * 5 * kGravity);
    for (BodyId i = 1; i < 5; ++i) {
        const double hang = 5 - i;
        EXPECT_NEAR(scene->load(i, i + 1)->shear_n, hang * kGravity, 0.001 * 5 * kGravity) << i;
        EXPECT_NEAR(scene->load(i, i + 1)->torque_nm(), hang * kGravity * 0.5 * hang * kCube_m, 0.001 * 5 * kGravity) << i;
    }
}

// Two rods that float, of 2 and of 3 bodies, turned against each other by a motor.
TEST(JoinedComposites, AMotorTurnsBothCompositesByTheirMomentsOfInertia) {
    auto scene = make_scene(without_sleep({}));
    for (BodyId i = 0; i < 5; ++i) need(scene->add_body({.id = i, .position_m = {i < 2 ? i - 0.5 : i - 3.0, 0, i < 2 ? 0.0 : 1.0}}));
    for (const auto& [one, other] : {std::pair{0, 1}, {2, 3}, {3, 4}})
        need(scene->connect(static_cast<BodyId>(one), static_cast<BodyId>(other)));
    need(scene->add_joint(
        {.first = 1, .second = 3, .anchor_m = {0, 0, 0.5}, .axis = {0, 0, 1}, .strength = 0.1, .drive = {JointDrive::Kind::Motor, 50}}));
    Workers workers(1);
    run(*scene, 240, 2, workers);
    const double first = 2 * (0.1 + 0.25), second = 3 * 0.1 + 2;
    EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, -0.1 / first, 1e-3 / first);
    EXPECT_NEAR(scene->state(4).angular_velocity_rad_s.z, 0.1 / second, 1e-3 / second);
    EXPECT_LT(length(scene->momentum()), 1e-6);
    EXPECT_LT(length(scene->angular_momentum()), 1e-6);
}

// A chain of rods, the first on a fixed body, and a heavy one at the end.
TEST(JoinedComposites, AChainOfRodsDoesNotStretchAndKeepsItsEnergy) {
    constexpr BodyId kRods = 30;
    auto scene = make_scene(without_sleep());
    need(scene->add_body({.id = 0, .position_m = {-0.5, 0, 0}, .radius_m = 0.1, .fixed = true}));
    for (BodyId rod = 0; rod < kRods; ++rod)
        for (BodyId i = 1; i <= 3; ++i) {
            const BodyId id = 3 * rod + i;
            need(scene->add_body({.id = id, .position_m = {1.0 * id - 1, 0, 0}, .radius_m = 0.2, .mass_kg = id == 3 * kRods ? 100.0 : 1}));
            if (i > 1)
                need(scene->connect(id - 1, id));
            else
                need(scene->add_joint({.first = id - 1, .second = id, .anchor_m = {1.0 * id - 1.5, 0, 0}, .axis = {0, 1, 0}}));
        }
    Workers workers(1);
    const double start = whole_energy(*scene), scale = kGravity * 100 * 3 * kRods;
    double worst = 0, stretched = 0;
    for (int tick = 0; tick < 1200; ++tick) {
        run(*scene, 1, 2, workers);
        worst = std::max(worst, std::abs(whole_energy(*scene) - start));
        for (BodyId id = 4; id <= 3 * kRods; id += 3) {
            const BodyState one = scene->state(id - 1), other = scene->state(id);
            stretched = std::max(stretched, length(one.position_m + rotate(one.orientation, {0.5, 0, 0}) - other.position_m -
                                                   rotate(other.orientation, {-0.5, 0, 0})));
        }
    }
    EXPECT_LT(worst, 0.01 * scale);
    EXPECT_LT(stretched, 1e-4);
}

// A pendulum of one ball that another one is connected to and released from as it swings; and a joint within a composite.
TEST(JoinedComposites, JointsFollowConnectionsThatAreMadeAndReleased) {
    auto scene = make_scene(without_sleep());
    need(scene->add_body({.id = 0, .position_m = {0, 0, 5}, .radius_m = 0.1, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {1, 0, 5}, .radius_m = 0.1}));
    need(scene->add_body({.id = 2, .position_m = {1.5, 0, 5}, .radius_m = 0.1}));
    need(scene->add_joint({.first = 0, .second = 1, .anchor_m = {0, 0, 5}, .axis = {0, 1, 0}}));
    need(scene->add_joint({.first = 1, .second = 2, .anchor_m = {1.25, 0, 5}, .axis = {0, 1, 0}}));
    Workers workers(1);
    const double start = whole_energy(*scene);
    const auto relative = [&] { return scene->joint(1, 2)->place; };
    need(scene->connect(1, 2));
    run(*scene, 100, 2, workers);
    EXPECT_NEAR(whole_energy(*scene), start, 0.01 * 2 * kGravity);
    EXPECT_NEAR(relative(), 0, 1e-6);
    EXPECT_EQ(scene->joint_load(1, 2)->force_n(), 0);
    need(scene->release(1, 2));
    run(*scene, 100, 2, workers);
    EXPECT_NEAR(whole_energy(*scene), start, 0.02 * 2 * kGravity);
    EXPECT_GT(std::abs(relative()), 0.02);
    // What is connected to something fixed stands, and holds the other.
    need(scene->connect(0, 1));
    run(*scene, 1, 2, workers);
    const Vec3 held = scene->state(1).position_m;
    run(*scene, 100, 2, workers);
    EXPECT_EQ(scene->state(1).position_m, held);
    const auto anchor = [&](BodyId body, double x) {
        const BodyState state = scene->state(body);
        return state.position_m + rotate(state.orientation, {x, 0, 0});
    };
    EXPECT_LT(length(anchor(1, 0.25) - anchor(2, -0.25)), 1e-5);
    // Both joints are idle.
    need(scene->connect(1, 2));
    run(*scene, 100, 2, workers);
    EXPECT_EQ(scene->joint(0, 1)->speed, 0);
    EXPECT_EQ(scene->joint(1, 2)->speed, 0);
    EXPECT_EQ(scene->joint_count(), 2u);
    need(scene->release(0, 1));
    run(*scene, 100, 2, workers);
    EXPECT_NEAR(length(scene->state(1).position_m - Vec3{0, 0, 5}), 1, 1e-5);
}

TEST(JoinedComposites, AJointThatHoldsAPieceBreaksAtItsWeight) {
    for (const bool breaks : {false, true}) {
        auto scene = make_scene(without_sleep());
        need(scene->add_body({.id = 0, .position_m = {0, 0, 5}, .fixed = true}));
        for (BodyId i = 1; i < 4; ++i) need(scene->add_body({.id = i, .position_m = {0, 0, 5.0 - i}}));
        need(scene->connect(1, 2)), need(scene->connect(2, 3));
        need(scene->add_joint({.kind = JointKind::Ball,
                               .first = 0,
                               .second = 1,
                               .anchor_m = {0, 0, 4.5},
                               .breaking_force_n = (breaks ? 0.98 : 1.02) * 3 * kGravity}));
        Workers workers(1);
        run(*scene, 60, 2, workers);
        EXPECT_EQ(scene->joint_count(), breaks ? 0u : 1u);
    }
}

// Arms of connected bodies on hinges, motors and sliders that reach over several blocks, one on a fixed piece; pieces that hang on each
// other, of which some joints and connections break; and balls that fall on them. Bodies of others are ghosts.
void add_arms(Scene& scene, const std::function<bool(BodyId)>& mine) {
    const BodyShape cube = box_shape({0.9, 0.9, 0.9}, 0.02);
    const auto add = [&](const BodySpec& spec, bool joined) {
        if (mine(spec.id))
            need(scene.add_body(spec));
        else if (joined)
            need(scene.add_ghost(spec));
        if (scene.has(spec.id) && spec.id % 4 == 0) need(scene.set_breaking(spec.id, {.force_n = 70 + 0.5 * spec.id, .torque_nm = 90}));
    };
    std::vector<JointSpec> joints;
    BodyId id = 0;
    for (int arm = 0; arm < 8; ++arm)
        for (int i = 0; i < 21; ++i, ++id) {
            const Vec3 at{1.0 * i - 12, 3.0 * arm - 9, 3 + 0.8 * arm};
            const bool joint_here = i > 0 && i % 3 == 0, joint_next = i % 3 == 2 && i < 20;
            BodySpec spec{.id = id, .position_m = at, .radius_m = 0.45, .fixed = arm == 1 && i == 10};
            if (arm % 3 == 1) spec.shape = cube;
            add(spec, joint_here || joint_next);
            if (i == 0) continue;
            if (!joint_here) {
                need(scene.connect(id - 1, id));
                continue;
            }
            joints.push_back({.first = id - 1, .second = id, .anchor_m = at - Vec3{0.5, 0, 0}, .axis = {0, 1, 0.3 * (arm % 2)}});
            JointSpec& joint = joints.back();
            if (arm == 2) joint.kind = JointKind::Ball, joint.breaking_force_n = 60 + i;
            if (arm == 3 || arm == 1)
                joint.strength = 25, joint.drive = {i % 2 == 0 ? JointDrive::Kind::Servo : JointDrive::Kind::Brake, 0.3};
            if (arm == 4) joint.kind = JointKind::Slider, joint.axis = {1, 0, 0}, joint.lower = -0.2, joint.upper = 0.4;
            if (arm == 5) joint.stiffness = 40, joint.damping = 1;
        }
    for (int i = 0; i < 120; ++i, ++id)
        add({.id = id,
             .position_m = {1.3 * (i % 10) - 6, 1.3 * (i / 10 % 6), 12 + 1.3 * (i / 60)},
             .linear_velocity_m_s = {0.1 * (i % 7) - 0.3, 0, 0},
             .radius_m = 0.4,
             .shape = i % 7 == 3 ? std::optional(cube) : std::nullopt},
            false);
    for (const JointSpec& joint : joints) need(scene.add_joint(joint));
}

void put_ground(Scene& scene) { need(scene.add_obstacle(Plane{}, need(scene.add_material({.friction = 0.4f, .restitution = 0.3f})))); }

void furnish_arms(Scene& scene, const std::function<bool(BodyId)>& mine) {
    scene.have_all_joined();
    put_ground(scene);
    add_arms(scene, mine);
}

TEST(JoinedComposites, MoveAlikeOnAllThreadsAndFromASnapshot) {
    const auto empty = [] {
        auto scene = make_scene(settings_for_shapes());
        put_ground(*scene);
        scene->want_loads();
        return scene;
    };
    expect_same_bits(empty, [](Scene& scene) { add_arms(scene, [](BodyId) { return true; }); });
}

// What is connected and released while arms fall: parts of arms, also over their joints, and balls that are free.
void change_arms(int tick, Scene& scene) {
    if (tick % 10 != 5) return;
    const auto step = static_cast<BodyId>(tick);
    const auto gone = [&](BodyId id) { return id % 40 == 15 && id <= step; };
    for (BodyId id = step % 7 + 1; id < 168; id += 13)
        if (id % 21 > 0 && !gone(id - 1) && !gone(id)) need(scene.release(id - 1, id));
    for (BodyId id = 3 + step % 9; id < 165; id += 21)
        if (!gone(id) && !gone(id + 1)) need(scene.connect(id, id + 1));
    for (BodyId id = 170 + step % 17; id < 280; id += 41)
        if (!gone(id - 160)) need(scene.connect(id, id + 1)), need(scene.connect(id, id - 160));
    if (step % 40 == 15 && scene.has(step)) need(scene.remove_body(step));
    if (step % 40 == 15) scene.release_all(step);
}

TEST(JoinedComposites, GiveTheBitsOfTheUndividedWorldWhenDivided) {
    auto scene = make_scene(settings_for_shapes());
    furnish_arms(*scene, [](BodyId) { return true; });
    Workers workers(2);
    const auto halves = [](BlockCoordinates c) { return c.x < 0 ? 0 : 1; };
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    std::vector<std::unique_ptr<Divided>> all;
    for (const auto& [parts, owner] : {std::pair<int, Subdomain::OwnerOf>{2, halves}, {3, scattered}})
        all.push_back(std::make_unique<Divided>(parts, owner, furnish_arms, settings_for_shapes()));
    scene->want_loads();
    for (const auto& divided : all) divided->change([](Scene& part) { part.want_loads(); });
    std::size_t broke = 0, loads = 0;
    const std::size_t joints = scene->joint_count();
    for (int tick = 0; tick < 200; ++tick) {
        change_arms(tick, *scene);
        run(*scene, 1, 2, workers);
        const auto broken = need(scene->solve_loads(workers));
        broke += broken.size();
        for (const auto& divided : all) {
            divided->change([&](Scene& part) { change_arms(tick, part); });
            divided->tick();
            ASSERT_EQ(divided->digest(), scene->digest()) << tick;
            ASSERT_EQ(divided->joints(), scene->joint_count()) << tick;
            ASSERT_EQ(divided->break_connections(), broken) << tick;
            for (const auto& [pair, load] : divided->loads()) {
                const auto at = scene->load(pair.first, pair.second);
                ASSERT_TRUE(at && *at == load) << tick << ": " << pair.first << " " << pair.second;
                ++loads;
            }
        }
    }
    EXPECT_GT(broke, 3u);
    EXPECT_GT(loads, 1000u);
    EXPECT_LT(scene->joint_count(), joints);
}

// Joints that are made and taken off while arms fall, near and far, also of what has had none yet. As the undivided world says, which has
// all bodies.
struct JointsChanged {
    struct Made {
        JointSpec spec;
        JointPose first, second;
    };
    std::vector<Made> made;
    std::vector<ConnectionPair> ended;

    void apply(Scene& scene) const {
        for (const auto& [one, other] : ended) need(scene.remove_joint(one, other));
        for (const auto& [spec, first, second] : made) need(scene.add_joint(spec, first, second));
    }
};

JointsChanged joints_to_change(int tick, const Scene& scene) {
    JointsChanged change;
    if (tick % 4 == 1)
        for (std::size_t j = static_cast<std::size_t>(tick) % 5; j < scene.joints().size(); j += 9)
            change.ended.push_back(std::minmax(scene.joints()[j].first, scene.joints()[j].second));
    const auto add = [&](BodyId first, BodyId second, JointKind kind) {
        if (!scene.has(first) || !scene.has(second) || scene.joined(first, second) || (scene.fixed(first) && scene.fixed(second))) return;
        const Vec3 one = scene.state(first).position_m, other = scene.state(second).position_m;
        change.made.push_back({{.kind = kind, .first = first, .second = second, .anchor_m = one + 0.5 * (other - one), .axis = {0, 1, 0}},
                               scene.pose(first),
                               scene.pose(second)});
    };
    const auto step = static_cast<BodyId>(tick);
    if (tick % 3 == 0) {
        add(step % 168, 170 + step % 118, JointKind::Ball);
        add(168 + step * 7 % 120, 168 + (step * 7 + 31) % 120, JointKind::Slider);
        add(step * 5 % 160 + 1, step * 5 % 160, JointKind::Hinge);
    }
    return change;
}

TEST(JoinedComposites, GiveTheSameBitsWhenJointsAreMadeAndTakenOffWhereverTheirBodiesAre) {
    auto scene = make_scene(settings_for_shapes());
    furnish_arms(*scene, [](BodyId) { return true; });
    Workers workers(2);
    const auto halves = [](BlockCoordinates c) { return c.x < 0 ? 0 : 1; };
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    std::vector<std::unique_ptr<Divided>> all;
    for (const auto& [parts, owner] : {std::pair<int, Subdomain::OwnerOf>{2, halves}, {3, scattered}})
        all.push_back(std::make_unique<Divided>(parts, owner, furnish_arms, settings_for_shapes()));
    std::size_t made = 0, ended = 0;
    for (int tick = 0; tick < 150; ++tick) {
        change_arms(tick, *scene);
        const JointsChanged changes = joints_to_change(tick, *scene);
        made += changes.made.size(), ended += changes.ended.size();
        changes.apply(*scene);
        run(*scene, 1, 2, workers);
        for (const auto& divided : all) {
            divided->change([&](Scene& part) { change_arms(tick, part), changes.apply(part); });
            divided->tick();
            ASSERT_EQ(divided->digest(), scene->digest()) << tick;
            ASSERT_EQ(divided->joints(), scene->joint_count()) << tick;
        }
    }
    EXPECT_GT(made, 100u);
    EXPECT_GT(ended, 50u);
}

TEST(JoinedComposites, AJointThatIsTakenOffLetsItsBodiesFallAndTouch) {
    auto scene = make_scene(without_sleep());
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0}, .fixed = true}));
    need(scene->add_body({.id = 1, .position_m = {0, 0, 0.6}}));
    need(scene->add_joint({.kind = JointKind::Slider, .first = 0, .second = 1, .axis = {1, 0, 0}, .upper = 0}));
    Workers workers(1);
    run(*scene, 20, 2, workers);
    EXPECT_NEAR(scene->state(1).position_m.z, 0.6, 1e-6);
    EXPECT_TRUE(scene->events().empty());
    need(scene->remove_joint(1, 0));
    EXPECT_FALSE(scene->remove_joint(0, 1));
    EXPECT_FALSE(scene->joined(0, 1));
    run(*scene, 1, 2, workers);
    ASSERT_EQ(scene->events().size(), 1u);
    EXPECT_TRUE(scene->events()[0].began);
    run(*scene, 200, 2, workers);
    EXPECT_GT(length(scene->state(1).position_m), 0.65);
    EXPECT_EQ(scene->joint_count(), 0u);
}

}  // namespace
}  // namespace meld::physics
