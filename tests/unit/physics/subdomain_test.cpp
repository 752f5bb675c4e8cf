// A world divided among parts, with the messages carried by hand, gives the bits of the undivided world.
#include "physics/scene/subdomain.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/physics/divided_world.h"

namespace meld::physics {
namespace {

// The same world in any number of parts: a falling cloud, a box, magnets on every other ball, a pile that sleeps.
void furnish(Scene& scene, const std::function<bool(BodyId)>& mine) {
    const auto bouncy = need(scene.add_material({.friction = 0.3f, .restitution = 0.3f}));
    need(scene.add_obstacle(Plane{}, bouncy));
    need(scene.add_obstacle(Box{.centre = {6, 6, 1}, .size_m = {3, 2, 2}}, 0));
    std::vector<Feature> features;
    for (const Vec3 direction : feature_directions(12))
        features.push_back({.direction = direction, .strength = 300, .depth_m = 0.05, .range_m = 0.2});
    const auto table = need(scene.add_feature_table(features));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2), radius(0.3, 0.5), speed(-3, 3);
    for (BodyId id = 0; id < 900; ++id) {
        const double r = radius(random);
        const Vec3 at{1.25 * (id % 12) + jitter(random), 1.25 * (id / 12 % 12) + jitter(random), 2.5 + 1.25 * (id / 144) + jitter(random)};
        const Vec3 velocity{speed(random), speed(random), speed(random)};
        if (!mine(id)) continue;
        need(scene.add_body({.id = id, .position_m = at, .linear_velocity_m_s = velocity, .radius_m = r, .mass_kg = 8 * r * r * r}));
        if (id % 2 == 0) need(scene.set_feature_table(id, table)), need(scene.set_features(id, 0xfff, id % 3 == 0 ? 0xfff : 0));
    }
    for (BodyId id = 900; id < 1100; ++id)
        if (mine(id))
            need(scene.add_body(
                {.id = id, .position_m = {40 + 1.0 * (id % 5), 1.0 * (id / 5 % 5), 0.5 + 1.0 * ((id - 900) / 25)}, .material = 0}));
}

// Balls at 250 to 900 m/s through a loose crowd.
void furnish_range(Scene& scene, const std::function<bool(BodyId)>& mine) {
    const auto bouncy = need(scene.add_material({.friction = 0.3f, .restitution = 0.7f}));
    for (BodyId id = 0; id < 343; ++id)
        if (mine(id))
            need(scene.add_body({.id = id,
                                 .position_m = {4.0 * (id % 7) + 0.1 * (id % 3), 4.0 * (id / 7 % 7), 5 + 4.0 * (id / 49) + 0.1 * (id % 5)},
                                 .radius_m = 0.3 + 0.1 * (id % 3),
                                 .material = bouncy}));
    for (BodyId id = 343; id < 349; ++id)
        if (mine(id))
            need(scene.add_body({.id = id,
                                 .position_m = {-20.0 - 7 * (id % 3), 4.0 * (id - 343), 9.2 + 4 * (id % 4)},
                                 .linear_velocity_m_s = {250 + 130.0 * (id - 343), 0, -5},
                                 .material = bouncy}));
}

// Spinning cubes, boxes, capsules, cylinders and balls fall on a box and on each other; cubes fly through them; far from them a pile of
// balls sleeps, and on the other side a stack of cubes.
void furnish_shapes(Scene& scene, const std::function<bool(BodyId)>& mine) {
    const auto bouncy = need(scene.add_material({.friction = 0.4f, .restitution = 0.3f}));
    need(scene.add_obstacle(Plane{}, bouncy));
    need(scene.add_obstacle(Box{.centre = {6, 6, 1}, .size_m = {3, 2, 2}}, 0));
    const BodyShape shapes[] = {box_shape({0.8, 0.8, 0.8}, 0.02), box_shape({0.4, 0.8, 1.2}, 0.05), capsule_shape(0.3, 1.4),
                                cylinder_shape(0.45, 0.7, 0.02), cylinder_shape(0.3, 1.2, 0)};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2), speed(-4, 4);
    for (BodyId id = 0; id < 343; ++id) {
        BodySpec spec{.id = id,
                      .position_m = {1.9 * (id % 7) + jitter(random), 1.9 * (id / 7 % 7) + jitter(random), 3 + 1.9 * (id / 49)},
                      .linear_velocity_m_s = {speed(random), speed(random), speed(random)},
                      .angular_velocity_rad_s = {speed(random), speed(random), speed(random)},
                      .radius_m = 0.4,
                      .material = static_cast<std::uint8_t>(id % 3 == 0 ? bouncy : 0)};
        if (id % 6 < 5) spec.shape = shapes[id % 6];
        if (mine(id)) need(scene.add_body(spec));
    }
    for (BodyId id = 343; id < 349; ++id)
        if (mine(id))
            need(scene.add_body({.id = id,
                                 .position_m = {-20.0 - 3 * id % 7, 2.0 * (id - 343), 4.0 + id % 3},
                                 .linear_velocity_m_s = {60 + 10.0 * (id - 343), 0, -1},
                                 .shape = shapes[0]}));
    for (BodyId id = 400; id < 464; ++id) {
        const Vec3 at{1.0 * (id % 4), 1.0 * (id / 4 % 4), 1.0 * ((id - 400) / 16)};
        if (mine(id)) need(scene.add_body({.id = id, .position_m = Vec3{120, 0, 0.5} + at}));
        if (mine(id + 64)) need(scene.add_body({.id = id + 64, .position_m = Vec3{-60, 0, 0.4} + 0.8 * at, .shape = shapes[0]}));
    }
}

// Joints of all kinds in a world that falls and sleeps: chains that reach over several blocks, beside each other and on a fixed body, a
// ring, a motor that turns two bodies far from each other, ropes that break, and balls among them. Bodies of others are ghosts.
void furnish_joints(Scene& scene, const std::function<bool(BodyId)>& mine) {
    const auto bouncy = need(scene.add_material({.friction = 0.4f, .restitution = 0.2f}));
    need(scene.add_obstacle(Plane{}, bouncy));
    const auto add = [&](const BodySpec& spec) { need(mine(spec.id) ? scene.add_body(spec) : scene.add_ghost(spec)); };
    std::vector<JointSpec> joints;
    BodyId id = 0;
    for (int c = 0; c < 6; ++c)
        for (int i = 0; i < 30; ++i, ++id) {
            const Vec3 at{1.0 * i - 12, 3.0 * c, 3 + 0.7 * c};
            add({.id = id, .position_m = at, .radius_m = 0.45, .fixed = c == 0 && i == 15});
            if (i == 0) continue;
            joints.push_back({.first = id - 1, .second = id, .anchor_m = at - Vec3{0.5, 0, 0}, .axis = {0, 1, 0.3 * (c % 2)}});
            JointSpec& joint = joints.back();
            if (c == 2) joint.kind = JointKind::Ball, joint.breaking_force_n = 40 + i;
            if (c == 3) joint.strength = 5, joint.drive = {i % 2 == 0 ? JointDrive::Kind::Servo : JointDrive::Kind::Brake, 0.3};
            if (c == 4 && i % 4 == 0) joint.kind = JointKind::Slider, joint.axis = {1, 0, 0}, joint.lower = -0.2, joint.upper = 0.4;
            if (c == 5) joint.stiffness = 20, joint.damping = 1;
        }
    const BodyId ring = id;
    for (int i = 0; i < 12; ++i, ++id) {
        const double angle = i * std::numbers::pi / 6;
        add({.id = id, .position_m = {14 + 2 * std::cos(angle), -6, 4 + 2 * std::sin(angle)}, .shape = box_shape({0.5, 0.5, 0.5}, 0.05)});
        const double half = angle - std::numbers::pi / 12;
        if (i > 0)
            joints.push_back(
                {.first = id - 1, .second = id, .anchor_m = {14 + 2 * std::cos(half), -6, 4 + 2 * std::sin(half)}, .axis = {0, 1, 0}});
    }
    const double between = -std::numbers::pi / 12;
    joints.push_back(
        {.first = ring, .second = ring + 11, .anchor_m = {14 + 2 * std::cos(between), -6, 4 + 2 * std::sin(between)}, .axis = {0, 1, 0}});
    // Far from each other; and one that hangs by itself on a fixed body far away.
    add({.id = id, .position_m = {-40, 0, 8}}), add({.id = id + 1, .position_m = {30, 1, 8}});
    joints.push_back({.first = id, .second = id + 1, .anchor_m = {0, 0, 8}, .axis = {1, 0, 0}});
    joints.back().strength = 3, joints.back().drive = {JointDrive::Kind::Motor, 4};
    id += 2;
    add({.id = id, .position_m = {-20, -25, 20}, .fixed = true}), add({.id = id + 1, .position_m = {20, -25, 20}});
    joints.push_back({.first = id, .second = id + 1, .anchor_m = {-20, -25, 20}, .axis = {0, 1, 0}});
    id += 2;
    // A crowd, of which some come fast.
    std::mt19937 random(7);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2), speed(-3, 3);
    for (int i = 0; i < 200; ++i, ++id) {
        const Vec3 at{1.3 * (i % 10) - 6 + jitter(random), 1.3 * (i / 10 % 10) + jitter(random), 9 + 1.3 * (i / 100)};
        const Vec3 velocity{speed(random), speed(random), speed(random)};
        if (!mine(id)) continue;
        need(scene.add_body({.id = id, .position_m = at, .linear_velocity_m_s = velocity, .radius_m = 0.4, .material = bouncy}));
    }
    for (const JointSpec& joint : joints) need(scene.add_joint(joint));
}

Digest undivided(int ticks, Furnish furnish_it = furnish, const Settings& settings = settings_for_parts()) {
    auto scene = make_scene(settings);
    furnish_it(*scene, [](BodyId) { return true; });
    Workers workers(1);
    run(*scene, ticks, 2, workers);
    return scene->digest();
}

TEST(Parts, GiveTheBitsOfTheUndividedWorld) {
    const int ticks = 60;
    const Digest whole = undivided(ticks);
    const auto halves = [](BlockCoordinates c) { return c.x < 1 ? 0 : 1; };
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    const std::pair<int, Subdomain::OwnerOf> divisions[] = {{1, [](BlockCoordinates) { return 0; }}, {2, halves}, {3, scattered}};
    for (const auto& [parts, owner] : divisions) {
        Divided divided(parts, owner, furnish);
        for (int tick = 0; tick < ticks; ++tick) divided.tick();
        EXPECT_EQ(divided.digest(), whole) << parts;
        EXPECT_EQ(divided.bodies(), 1100u);
        EXPECT_GT(divided.rebuilds, 3);
        EXPECT_EQ(divided.sent_bytes > 0, parts > 1);
        EXPECT_EQ(divided.part(0).border_blocks().empty(), parts == 1);
    }
}

// Fast bodies reach far into the blocks of other parts, and the fastest make all blocks larger.
TEST(Parts, GiveTheBitsOfTheUndividedWorldUnderFire) {
    const int ticks = 40;
    const Digest whole = undivided(ticks, furnish_range);
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    Divided divided(3, scattered, furnish_range);
    for (int tick = 0; tick < ticks; ++tick) divided.tick();
    EXPECT_EQ(divided.digest(), whole);
    EXPECT_EQ(divided.bodies(), 349u);
}

// Also where a part has no body with a shape.
TEST(Parts, GiveTheBitsOfTheUndividedWorldWithShapes) {
    const int ticks = 150;
    const Settings settings = settings_for_shapes();
    const Digest whole = undivided(ticks, furnish_shapes, settings);
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    const auto far_balls = [](BlockCoordinates c) { return c.x > 4 ? 0 : 1; };
    const auto halves = [](BlockCoordinates c) { return c.x < 1 ? 0 : 1; };
    for (const auto& [parts, owner] : {std::pair<int, Subdomain::OwnerOf>{2, halves}, {3, scattered}, {2, far_balls}}) {
        Divided divided(parts, owner, furnish_shapes, settings);
        for (int tick = 0; tick < ticks; ++tick) divided.tick();
        EXPECT_EQ(divided.digest(), whole);
        EXPECT_EQ(divided.bodies(), 349u + 128u);
        EXPECT_GT(divided.rebuilds, 10);
    }
}

TEST(Parts, MayBeDividedAnewWithShapes) {
    const int ticks = 100;
    int shift = 0;
    Divided divided(
        2, [&](BlockCoordinates c) { return c.x + c.y < 1 + shift % 5 ? shift % 2 : 1 - shift % 2; }, furnish_shapes,
        settings_for_shapes());
    for (int tick = 0; tick < ticks; ++tick) {
        if (divided.must_rebuild()) ++shift;
        divided.tick();
    }
    EXPECT_GT(shift, 5);
    EXPECT_EQ(divided.digest(), undivided(ticks, furnish_shapes, settings_for_shapes()));
}

// Mechanisms reach over many blocks and parts, break, fall asleep and wake.
TEST(Parts, GiveTheBitsOfTheUndividedWorldWithJoints) {
    const int ticks = 300;
    auto scene = make_scene(settings_for_shapes());
    furnish_joints(*scene, [](BodyId) { return true; });
    const std::size_t joints = scene->joint_count();
    Workers workers(1);
    const auto halves = [](BlockCoordinates c) { return c.x < 0 ? 0 : 1; };
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    const auto one_has_all = [](BlockCoordinates) { return 1; };
    std::vector<std::unique_ptr<Divided>> all;
    for (const auto& [parts, owner] :
         {std::pair<int, Subdomain::OwnerOf>{1, [](BlockCoordinates) { return 0; }}, {2, halves}, {3, scattered}, {2, one_has_all}})
        all.push_back(std::make_unique<Divided>(parts, owner, furnish_joints, settings_for_shapes()));
    std::size_t slept = 0;
    for (int tick = 0; tick < ticks; ++tick) {
        if (tick == 200)
            for (BodyId i = 91; i < 120; ++i) {
                need(scene->drive_joint(i - 1, i, {JointDrive::Kind::Motor, 1}));
                for (const auto& divided : all) divided->drive(i - 1, i, {JointDrive::Kind::Motor, 1});
            }
        run(*scene, 1, 2, workers);
        slept += scene->awake_bodies() < scene->body_count() ? 1 : 0;
        for (const auto& divided : all) {
            divided->tick();
            ASSERT_EQ(divided->digest(), scene->digest()) << tick;
            ASSERT_EQ(divided->joints(), scene->joint_count()) << tick;
        }
    }
    EXPECT_GT(slept, 10u);
    EXPECT_LT(scene->joint_count(), joints);
}

TEST(Parts, MayBeDividedAnewWithJoints) {
    expect_same_bits_divided_anew(furnish_joints, [](Scene&) {}, [](int, Divided&, Scene&, Workers&) {});
}

// Whatever bounces costs exchanges in the ticks in which it does. Without, a tick has those of one colour for each of 8 colours of
// the magnets, 2 warm starts, 4 sweeps and 2 relaxing ones, and one about sleep.
TEST(Parts, ExchangeBouncesOnlyWhereSomethingBounces) {
    Divided divided(2, [](BlockCoordinates c) { return c.x < 1 ? 0 : 1; }, furnish);
    const int without = 1 + 8 * (1 + 2 + 4 + 2), with_all = without + 8 * 4 * 3;
    int least = with_all, most = 0;
    for (int tick = 0; tick < 120; ++tick) {
        const int before = divided.exchanges;
        divided.tick();
        least = std::min(least, divided.exchanges - before);
        most = std::max(most, divided.exchanges - before);
    }
    EXPECT_EQ(least, without);
    EXPECT_GT(most, without);
    EXPECT_LT(most, with_all);
}

TEST(Parts, KnowTogetherWhatPressesOnTheirBodies) {
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    const auto compare = [&](Furnish furnish_it, const Settings& settings, std::size_t least) {
        Divided one(1, [](BlockCoordinates) { return 0; }, furnish_it, settings), three(3, scattered, furnish_it, settings);
        std::size_t pressed = 0;
        for (int tick = 0; tick < 60; ++tick) {
            one.tick(), three.tick();
            const std::map<BodyId, double> forces = one.normal_forces();
            ASSERT_EQ(three.normal_forces(), forces) << tick;
            for (const auto& [body, force_n] : forces) pressed += force_n > 0 ? 1 : 0;
        }
        EXPECT_GT(pressed, least);
    };
    compare(furnish, settings_for_parts(), 10'000);
    compare(furnish_shapes, settings_for_shapes(), 7'000);
}

// Blocks may change hands whenever bodies do, also those that sleep, and whole parts may be emptied.
TEST(Parts, MayBeDividedAnewWithTheSameBits) {
    const int ticks = 60;
    int shift = 0;
    Divided divided(2, [&](BlockCoordinates c) { return c.x + c.y < 1 + shift % 5 ? shift % 2 : 1 - shift % 2; }, furnish);
    for (int tick = 0; tick < ticks; ++tick) {
        if (divided.must_rebuild()) ++shift;
        divided.tick();
    }
    EXPECT_GT(shift, 5);
    EXPECT_EQ(divided.digest(), undivided(ticks));
    EXPECT_EQ(divided.bodies(), 1100u);
}

TEST(Parts, KnowWhatTheirBodiesWeighAndWhoHoldsThem) {
    Divided divided(2, [](BlockCoordinates c) { return c.x < 1 ? 0 : 1; }, furnish);
    for (int tick = 0; tick < 60; ++tick) divided.tick();
    std::uint32_t weight = 0;
    for (const std::size_t part : {0u, 1u})
        for (const auto& [block, of_block] : divided.part(part).weights()) weight += of_block;
    // The 200 that lie in a pile sleep by now; the 900 fall.
    EXPECT_EQ(weight, 4 * 900u + 200u);
    // The pile is far from the border, and body 0 beside it.
    EXPECT_TRUE(divided.part(1).holders_of(1000).empty());
    EXPECT_EQ(divided.part(0).holders_of(0), std::vector<int>{1});
    EXPECT_EQ(divided.part(0).owner_of(0), 0);
}

// A part may begin with nothing and get its first body, with what it had switched on.
TEST(Parts, HandABodyToOneThatHasNone) {
    auto first = make_scene(settings_for_parts()), second = make_scene(settings_for_parts());
    for (Scene* scene : {first.get(), second.get()}) need(scene->add_feature_table({{.direction = {0, 0, 1}, .power_w = 1}}));
    need(first->add_body({.id = 4, .position_m = {1, 1, 1}}));
    need(first->set_feature_table(4, 1));
    need(first->set_features(4, 1, 1));
    const auto owner = [](BlockCoordinates) { return 1; };
    Subdomain from(*first, owner, 0, 2), to(*second, owner, 1, 2);
    Workers workers(1);
    auto sent = from.pack_bodies(workers);
    EXPECT_EQ(from.departed(), (std::vector<std::pair<BodyId, int>>{{4, 1}}));
    need(to.unpack_bodies(sent.at(1).view()));
    to.unpacked();
    ASSERT_TRUE(second->has(4));
    EXPECT_EQ(second->features(4).on, 1u);
    EXPECT_EQ(second->features(4).reversed, 1u);
    EXPECT_FALSE(first->has(4));
}

}  // namespace
}  // namespace meld::physics
