// Rigid composites against mechanics: what hangs, falls, spins, rolls and collides as one.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "physics/scene/subdomain.h"
#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

Settings weightless() {
    Settings settings;
    settings.gravity_m_s2 = {};
    return settings;
}

// Balls in a row along x that are connected, from this body and place on.
void add_row(Scene& scene, BodyId first, int count, Vec3 where, Vec3 velocity = {}) {
    for (int i = 0; i < count; ++i) {
        need(scene.add_body({.id = first + BodyId(i), .position_m = where + Vec3{double(i), 0, 0}, .linear_velocity_m_s = velocity}));
        if (i > 0) need(scene.connect(first + BodyId(i) - 1, first + BodyId(i)));
    }
}

// How far the shape of some bodies is from that at the start: the greatest change of a distance from the first.
class Shape {
  public:
    Shape(const Scene& scene, std::vector<BodyId> bodies) : bodies_(std::move(bodies)) {
        for (const BodyId body : bodies_) distances_.push_back(distance(scene, body));
    }
    double change(const Scene& scene) const {
        double most = 0;
        for (std::size_t i = 0; i < bodies_.size(); ++i) most = std::max(most, std::abs(distance(scene, bodies_[i]) - distances_[i]));
        return most;
    }

  private:
    double distance(const Scene& scene, BodyId body) const {
        return length(scene.state(body).position_m - scene.state(bodies_[0]).position_m);
    }
    std::vector<BodyId> bodies_;
    std::vector<double> distances_;
};

TEST(Composites, ACantileverDoesNotSag) {
    for (const int length : {10, 50, 100, 1000}) {
        auto scene = make_scene();
        need(scene->add_body({.id = 5000, .position_m = {-1, 0, 3}, .fixed = true}));
        add_row(*scene, 0, length, {0, 0, 3});
        need(scene->connect(5000, 0));
        // A ball lies on its end, so that something presses on it.
        need(scene->add_body({.id = 6000, .position_m = {double(length - 1), 0, 4}, .mass_kg = 50}));
        Workers workers(1);
        run(*scene, 240, 2, workers);
        for (const BodyId body : {BodyId(0), BodyId(length - 1)})
            EXPECT_LT(physics::length(scene->state(body).position_m - Vec3{double(body), 0, 3}), 1e-6) << length;
        EXPECT_NEAR(scene->state(6000).position_m.z, 4, 1e-3);
        EXPECT_TRUE(scene->composite(3)->carried);
    }
}

TEST(Composites, ALongRowRestsOnItsEnds) {
    // Two fixed balls carry a row of 200 that reaches over many blocks.
    auto scene = make_scene();
    need(scene->add_body({.id = 5000, .position_m = {0, 0, 0}, .fixed = true}));
    need(scene->add_body({.id = 5001, .position_m = {199, 0, 0}, .fixed = true}));
    add_row(*scene, 0, 200, {0, 0, 1});
    Workers workers(2);
    run(*scene, 240, 2, workers);
    for (BodyId body = 0; body < 200; ++body) EXPECT_NEAR(scene->state(body).position_m.z, 1, 1e-3) << body;
    double weight = 0;
    for (const ContactReport& contact : scene->contacts()) weight += contact.normal_force_n;
    EXPECT_NEAR(weight, 200 * kGravity, 0.01 * 200 * kGravity);
}

TEST(Composites, APlateOverManyBlocksComesToRest) {
    // 24 x 24 balls over several blocks fall with a spin on a plane, and loose balls fall on them. Then all lie still: the plate flat, the
    // plane carries the whole weight, and nothing has sunk in.
    auto scene = scene_on_plane();
    const int side = 24;
    const double tilt = 0.02;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const auto id = BodyId(side * y + x);
            need(scene->add_body({.id = id, .position_m = {x * std::cos(tilt), double(y), 0.7 + x * std::sin(tilt)}}));
            if (x > 0) need(scene->connect(id - 1, id));
            if (y > 0 && x % 5 == 0) need(scene->connect(id - BodyId(side), id));
        }
    for (BodyId i = 0; i < 16; ++i)
        need(scene->add_body({.id = 1000 + i, .position_m = {2.5 + 6 * (i % 4), 2.5 + 6 * double(i / 4), 3}, .mass_kg = 3}));
    Workers workers(2);
    run(*scene, 960, 2, workers);
    EXPECT_GT(scene->step(kTick, 2, workers)->blocks, 8u);
    EXPECT_LT(scene->kinetic_energy_j(), 1e-3);
    for (BodyId id = 0; id < BodyId(side * side); ++id) EXPECT_NEAR(scene->state(id).position_m.z, 0.5, 2e-3) << id;
    double carried = 0;
    for (const ContactReport& contact : scene->contacts())
        if (contact.touch.other_is_obstacle) carried += contact.normal_force_n;
    const double weight = (side * side + 16 * 3) * kGravity;
    EXPECT_NEAR(carried, weight, 0.01 * weight);
}

TEST(Composites, AConnectionMoreOrLessInALoopChangesNothing) {
    const auto digest = [](bool loop) {
        auto scene = make_scene(weightless());
        add_row(*scene, 0, 6, {0, 0, 0}, {0.1, 0.2, 0});
        need(scene->add_body({.id = 6, .position_m = {0, 1, 0}, .linear_velocity_m_s = {0, 1, 0}}));
        need(scene->connect(0, 6));
        Workers workers(1);
        run(*scene, 3, 2, workers);
        if (loop) need(scene->connect(1, 6));
        run(*scene, 3, 2, workers);
        EXPECT_EQ(scene->composite(6)->bodies, 7u);
        if (loop) need(scene->release(0, 1));
        run(*scene, 3, 2, workers);
        EXPECT_EQ(scene->composite(0)->bodies, 7u);
        return scene->digest();
    };
    EXPECT_EQ(digest(true), digest(false));
}

TEST(Composites, FallFreelyAndKeepMomentumAndAngularMomentum) {
    auto scene = make_scene(weightless());
    // An L of 40 balls of two masses that tumbles about no axis of its own.
    std::vector<BodyId> all;
    for (BodyId id = 0; id < 40; ++id) {
        const Vec3 where = id < 30 ? Vec3{double(id), 0, 0} : Vec3{0, double(id - 29), 0.3 * (id - 29)};
        need(scene->add_body({.id = id, .position_m = where, .mass_kg = id % 3 == 0 ? 2.0 : 1.0}));
        all.push_back(id);
    }
    const Vec3 spin{0.3, 0.7, -0.4}, drift{0.5, -0.2, 0.1};
    for (BodyId id = 0; id < 40; ++id) {
        BodyState state = scene->state(id);
        state.linear_velocity_m_s = drift + cross(spin, state.position_m), state.angular_velocity_rad_s = spin;
        need(scene->set_state(id, state));
        if (id > 0) need(scene->connect(id == 30 ? 0 : id - 1, id));
    }
    const Vec3 momentum = scene->momentum(), angular = scene->angular_momentum();
    const double energy = scene->kinetic_energy_j();
    const Shape shape(*scene, all);
    Workers workers(1);
    run(*scene, 1200, 2, workers);
    EXPECT_LT(length(scene->momentum() - momentum), 1e-6 * length(momentum));
    EXPECT_LT(length(scene->angular_momentum() - angular), 1e-6 * length(angular));
    EXPECT_NEAR(scene->kinetic_energy_j(), energy, 1e-5 * energy);
    EXPECT_LT(shape.change(*scene), 1e-9);
    EXPECT_GT(std::abs(scene->state(29).position_m.y), 1);
}

TEST(Composites, FallLikeSingleBodies) {
    auto scene = make_scene();
    add_row(*scene, 0, 20, {0, 0, 100}, {1, 0, 0});
    need(scene->add_body({.id = 100, .position_m = {0, 5, 100}, .linear_velocity_m_s = {1, 0, 0}}));
    Workers workers(1);
    run(*scene, 240, 2, workers);
    // Steps of h, each with the velocity at its end. A single body's velocity is in single precision.
    const double h = kTick / 2, n = 480, expected = 100 - kGravity * h * h * n * (n + 1) / 2;
    EXPECT_NEAR(scene->state(19).position_m.z, expected, 1e-6);
    EXPECT_NEAR(scene->state(100).position_m.z, expected, 1e-4);
    EXPECT_NEAR(scene->state(0).position_m.x, 1, 1e-5);
    EXPECT_NEAR(scene->acceleration(7).z, -kGravity, 1e-2);
}

TEST(Composites, AForceOnAMemberTurnsThem) {
    // A force F across the end of a rod of two balls at +-a: v' = F/2m, w' = F a / I with I = 2 m a^2 + 2 (2/5) m r^2.
    auto scene = make_scene(weightless());
    add_row(*scene, 0, 2, {-0.5, 0, 0});
    need(scene->set_wrench(1, {0, 1e-3, 0}, {}));
    Workers workers(1);
    run(*scene, 240, 2, workers);
    const double inertia = 2 * 0.25 + 2 * 0.4 * 0.25;
    const auto composite = scene->composite(0);
    EXPECT_NEAR(composite->linear_velocity_m_s.y, 1e-3 / 2, 1e-8);
    EXPECT_NEAR(composite->angular_velocity_rad_s.z, 1e-3 * 0.5 / inertia, 1e-8);
    EXPECT_NEAR(composite->inertia_kg_m2.zz, inertia, 1e-8);
    // It has turned by half a w t.
    const double turned = 0.5 * composite->angular_velocity_rad_s.z;
    EXPECT_NEAR(composite->inertia_kg_m2.xx, 2 * 0.4 * 0.25 + 0.5 * turned * turned, 1e-8);
}

TEST(Composites, ADumbbellRollsDownASlope) {
    // Two balls beside each other roll about their common axis like one: a = 5/7 g sin(angle). Their axis is across the slope.
    const double angle = 0.1;
    auto scene = make_scene();
    need(scene->add_obstacle(Plane{.normal = {std::sin(angle), 0, std::cos(angle)}}, 0));
    const Vec3 up = 0.5 * Vec3{std::sin(angle), 0, std::cos(angle)};
    need(scene->add_body({.id = 0, .position_m = up}));
    need(scene->add_body({.id = 1, .position_m = up + Vec3{0, 1, 0}}));
    need(scene->connect(0, 1));
    Workers workers(1);
    run(*scene, 240, 2, workers);
    const double expected = 5.0 / 7 * kGravity * std::sin(angle);
    EXPECT_NEAR(length(scene->state(0).linear_velocity_m_s), expected, 0.005 * expected);
    EXPECT_NEAR(scene->state(1).angular_velocity_rad_s.y, expected / 0.5, 0.01 * expected);
}

TEST(Composites, ADumbbellDoesNotRollAlongItsAxis) {
    // Across the slope's contour the two balls would have to slide: with friction 1 it stays on a slope of 30 degrees, and with friction
    // mu it slides with g (sin - mu cos).
    for (const float friction : {1.0f, 0.2f}) {
        const double angle = std::numbers::pi / 6;
        auto scene = make_scene();
        const auto material = need(scene->add_material({.friction = friction}));
        const Vec3 normal{std::sin(angle), 0, std::cos(angle)}, down{std::cos(angle), 0, -std::sin(angle)};
        need(scene->add_obstacle(Plane{.normal = normal}, material));
        for (BodyId id = 0; id < 2; ++id)
            need(scene->add_body({.id = id, .position_m = 0.5 * normal + double(id) * down, .material = material}));
        need(scene->connect(0, 1));
        Workers workers(1);
        run(*scene, 120, 2, workers);
        const double expected = 0.5 * kGravity * (std::sin(angle) - 0.2 * std::cos(angle));
        if (friction == 1)
            EXPECT_LT(length(scene->state(0).position_m - 0.5 * normal), 2e-3);
        else
            EXPECT_NEAR(dot(scene->state(0).linear_velocity_m_s, down), expected, 0.02 * expected);
    }
}

TEST(Composites, AStandingRowTipsOverLikeAPendulum) {
    // A column of n balls on a plane, its lowest held: it turns about the point of contact with the energy m g h (1 - cos) = I w^2 / 2.
    // A small start angle; measured where it has turned to 60 degrees.
    auto scene = scene_on_plane();
    const auto rough = need(scene->add_material({.friction = 100}));
    const int count = 8;
    const double lean = 0.05;
    for (int i = 0; i < count; ++i)
        need(scene->add_body({.id = BodyId(i), .position_m = {i * std::sin(lean), 0, 0.5 + i * std::cos(lean)}, .material = rough}));
    for (int i = 1; i < count; ++i) need(scene->connect(BodyId(i - 1), BodyId(i)));
    Workers workers(1);
    const double energy = scene->potential_energy_j();
    double angle = 0, speed = 0;
    for (int tick = 0; tick < 2000 && angle < std::numbers::pi / 3; ++tick) {
        run(*scene, 1, 4, workers);
        const Vec3 along = scene->state(count - 1).position_m - scene->state(0).position_m;
        angle = std::acos(along.z / (count - 1));
        speed = scene->state(0).angular_velocity_rad_s.y;
    }
    // It rolls on its lowest ball without slipping, which keeps its energy.
    EXPECT_NEAR(scene->kinetic_energy_j() + scene->potential_energy_j(), energy, 0.01 * (energy - scene->potential_energy_j()));
    // About the centre of the lowest ball, which moves with r w: the kinetic energy of rolling without slipping.
    double turning = 0, height = 0;
    for (int i = 0; i < count; ++i) {
        turning += 0.4 * 0.25 + (0.25 + i * i + 2 * 0.5 * i * std::cos(angle));
        height += i * (std::cos(lean) - std::cos(angle));
    }
    EXPECT_NEAR(speed, std::sqrt(2 * kGravity * height / turning), 0.01 * speed);
}

TEST(Composites, CollideWithRestitutionAndMomentum) {
    for (const double restitution : {0.0, 0.5, 1.0}) {
        for (const bool central : {true, false}) {
            auto scene = make_scene(weightless());
            const auto material = need(scene->add_material({.friction = 0, .restitution = float(restitution)}));
            // A rod of 3 along x, and a rod of 5 along y that it hits at its middle or its end.
            for (BodyId id = 0; id < 3; ++id)
                need(scene->add_body({.id = id, .position_m = {double(id), 0, 0}, .linear_velocity_m_s = {1, 0, 0}, .material = material}));
            for (BodyId id = 3; id < 8; ++id)
                need(scene->add_body({.id = id, .position_m = {3.3, double(id) - (central ? 5 : 3), 0}, .material = material}));
            for (BodyId id = 1; id < 8; ++id)
                if (id != 3) need(scene->connect(id - 1, id));
            const Vec3 momentum = scene->momentum(), angular = scene->angular_momentum();
            const double energy = scene->kinetic_energy_j();
            Workers workers(1);
            run(*scene, 120, 2, workers);
            EXPECT_LT(length(scene->momentum() - momentum), 1e-5 * length(momentum));
            EXPECT_LT(length(scene->angular_momentum() - angular), 1e-3 * (1 + length(angular)));
            // The contact's lightness: 1/3 + 1/5, and where it hits the end, 2^2 / I with I = 10 + 5 (2/5) / 4.
            const double lightness = 1.0 / 3 + 1.0 / 5 + (central ? 0 : 4 / 10.5), impulse = (1 + restitution) / lightness;
            EXPECT_NEAR(scene->composite(0)->linear_velocity_m_s.x, 1 - impulse / 3, 2e-3) << restitution << central;
            EXPECT_NEAR(scene->composite(3)->linear_velocity_m_s.x, impulse / 5, 2e-3);
            EXPECT_NEAR(scene->composite(3)->angular_velocity_rad_s.z, central ? 0 : 2 * impulse / 10.5, 3e-3);
            if (restitution == 1) {
                EXPECT_NEAR(scene->kinetic_energy_j(), energy, 1e-3 * energy);
            }
        }
    }
}

TEST(Composites, BounceOnAPlane) {
    // A composite that falls on one ball below its centre comes back with the share of the speed.
    auto scene = make_scene();
    const auto bouncy = need(scene->add_material({.friction = 0.5f, .restitution = 0.8f}));
    need(scene->add_obstacle(Plane{}, bouncy));
    for (BodyId id = 0; id < 3; ++id) need(scene->add_body({.id = id, .position_m = {0, 0, 2.5 + id}, .material = bouncy}));
    need(scene->connect(0, 1)), need(scene->connect(1, 2));
    Workers workers(1);
    double highest = 0;
    bool has_bounced = false;
    for (int tick = 0; tick < 300; ++tick) {
        run(*scene, 1, 2, workers);
        has_bounced = has_bounced || scene->state(0).linear_velocity_m_s.z > 1;
        if (has_bounced && scene->state(0).linear_velocity_m_s.z >= 0) highest = std::max(highest, scene->state(0).position_m.z - 0.5);
        if (has_bounced && scene->state(0).linear_velocity_m_s.z < 0) break;
    }
    EXPECT_NEAR(highest, 0.64 * 2, 0.02);
}

TEST(Composites, MergeAndSplitKeepMomentumAndVelocities) {
    auto scene = make_scene(weightless());
    add_row(*scene, 0, 5, {0, 0, 0}, {0, 1, 0});
    add_row(*scene, 5, 5, {5, 0, 0}, {0, -1, 0.5});
    Workers workers(1);
    run(*scene, 3, 2, workers);
    const Vec3 momentum = scene->momentum(), angular = scene->angular_momentum();
    need(scene->connect(4, 5));
    EXPECT_EQ(scene->composite(0)->bodies, 5u);
    run(*scene, 1, 2, workers);
    EXPECT_EQ(scene->composite(0)->bodies, 10u);
    EXPECT_EQ(scene->composite(9)->mass_kg, 10);
    EXPECT_LT(length(scene->momentum() - momentum), 1e-5);
    EXPECT_LT(length(scene->angular_momentum() - angular), 1e-4);
    run(*scene, 30, 2, workers);
    // All are released: each goes on as it moved within the composite.
    std::vector<BodyState> before;
    for (BodyId id = 0; id < 10; ++id) before.push_back(scene->state(id));
    for (BodyId id = 1; id < 10; ++id) need(scene->release(id - 1, id));
    const Vec3 whole = scene->momentum(), turning = scene->angular_momentum();
    run(*scene, 1, 2, workers);
    for (BodyId id = 0; id < 10; ++id) {
        EXPECT_FALSE(scene->composite(id));
        EXPECT_LT(length(scene->state(id).angular_velocity_rad_s - before[id].angular_velocity_rad_s), 1e-5);
        // Neighbours on a line part at once.
        EXPECT_LT(length(scene->state(id).linear_velocity_m_s - before[id].linear_velocity_m_s), 1e-2);
    }
    EXPECT_LT(length(scene->momentum() - whole), 1e-5);
    EXPECT_LT(length(scene->angular_momentum() - turning), 1e-4);
    // Free bodies are hit one by one again.
    need(scene->set_wrench(0, {0, 0, 10}, {}));
    run(*scene, 1, 2, workers);
    EXPECT_NEAR(scene->acceleration(0).z, 10, 0.1);
    EXPECT_NEAR(scene->acceleration(5).z, 0, 0.1);
}

TEST(Composites, MembersDoNotTouchEachOther) {
    auto scene = scene_on_plane();
    add_cube(*scene, 2);
    Workers workers(1);
    run(*scene, 2, 2, workers);
    const auto touches = [&](BodyId a, BodyId b) {
        for (const ContactReport& contact : scene->contacts())
            if (contact.touch == Touch{a, b, false}) return true;
        return false;
    };
    EXPECT_TRUE(touches(0, 4));
    EXPECT_TRUE(touches(1, 5));
    need(scene->connect(0, 4));
    run(*scene, 1, 2, workers);
    EXPECT_FALSE(touches(0, 4));
    EXPECT_TRUE(touches(1, 5));
    ASSERT_EQ(scene->events().size(), 1u);
    EXPECT_TRUE((scene->events()[0] == TouchEvent{{0, 4, false}, false}));
    need(scene->release(0, 4));
    run(*scene, 1, 2, workers);
    EXPECT_TRUE(touches(0, 4));
    ASSERT_EQ(scene->events().size(), 1u);
    EXPECT_TRUE((scene->events()[0] == TouchEvent{{0, 4, false}, true}));
}

TEST(Composites, SleepAsOneAndWakeAsOne) {
    // A row over several blocks sleeps; a blow at one end wakes the other.
    auto scene = scene_on_plane();
    add_row(*scene, 0, 60, {0, 0, 0.5});
    Workers workers(1);
    run(*scene, 300, 2, workers);
    EXPECT_TRUE(scene->asleep(0));
    EXPECT_TRUE(scene->asleep(59));
    EXPECT_EQ(scene->awake_bodies(), 0u);
    need(scene->set_wrench(0, {0, 0, 600}, {}));
    run(*scene, 20, 2, workers);
    EXPECT_FALSE(scene->asleep(59));
    EXPECT_GT(scene->state(0).position_m.z, 0.51);
    // While one end is shaken, the other does not fall asleep.
    for (int tick = 0; tick < 300; ++tick) {
        need(scene->set_wrench(0, {0, 0, tick % 40 < 20 ? 400.0 : 0.0}, {}));
        run(*scene, 1, 2, workers);
        ASSERT_FALSE(scene->asleep(59));
    }
    need(scene->set_wrench(0, {}, {}));
    run(*scene, 600, 2, workers);
    EXPECT_TRUE(scene->asleep(0));
    const Vec3 where = scene->state(30).position_m;
    run(*scene, 10, 2, workers);
    EXPECT_EQ(scene->state(30).position_m, where);
}

TEST(Composites, RemovingABodySplits) {
    auto scene = make_scene(weightless());
    add_row(*scene, 0, 7, {0, 0, 0}, {1, 0, 0});
    Workers workers(1);
    run(*scene, 2, 2, workers);
    need(scene->remove_body(3));
    run(*scene, 2, 2, workers);
    EXPECT_EQ(scene->composite(0)->bodies, 3u);
    EXPECT_EQ(scene->composite(6)->bodies, 3u);
    EXPECT_TRUE(scene->connected_to(2).size() == 1 && scene->connected_to(2)[0] == 1);
    EXPECT_NEAR(scene->state(6).linear_velocity_m_s.x, 1, 1e-6);
    // The number may be used again, and is connected to nothing.
    need(scene->add_body({.id = 3, .position_m = {3, 5, 0}}));
    run(*scene, 2, 2, workers);
    EXPECT_FALSE(scene->composite(3));
    need(scene->remove_body(0));
    need(scene->remove_body(1));
    run(*scene, 2, 2, workers);
    EXPECT_FALSE(scene->composite(2));
}

TEST(Composites, AMovingFixedBodyCarriesThem) {
    auto scene = make_scene();
    need(scene->add_body({.id = 0, .position_m = {0, 0, 5}, .angular_velocity_rad_s = {0, 0, 1}, .fixed = true}));
    add_row(*scene, 1, 10, {1, 0, 5});
    need(scene->connect(0, 1));
    Workers workers(1);
    run(*scene, 240, 2, workers);
    const Vec3 end = scene->state(10).position_m;
    EXPECT_NEAR(end.x, 10 * std::cos(1), 1e-5);
    EXPECT_NEAR(end.y, 10 * std::sin(1), 1e-5);
    EXPECT_NEAR(end.z, 5, 1e-9);
    EXPECT_NEAR(length(scene->state(10).linear_velocity_m_s), 10, 1e-5);
    // Its velocity may be set; the others follow.
    BodyState state = scene->state(0);
    state.angular_velocity_rad_s = {}, state.linear_velocity_m_s = {0, 0, 2};
    need(scene->set_state(0, state));
    run(*scene, 120, 2, workers);
    EXPECT_NEAR(scene->state(10).position_m.z, 6, 1e-5);
    EXPECT_NEAR(scene->state(10).position_m.x, end.x, 1e-5);
}

TEST(Composites, SetStateMakesThemAnew) {
    auto scene = make_scene(weightless());
    add_row(*scene, 0, 4, {0, 0, 0});
    Workers workers(1);
    run(*scene, 2, 2, workers);
    BodyState state = scene->state(3);
    state.position_m = {2, 1, 0}, state.linear_velocity_m_s = {0, 0, 4};
    need(scene->set_state(3, state));
    run(*scene, 1, 2, workers);
    EXPECT_NEAR(scene->momentum().z, 4, 1e-5);
    EXPECT_NEAR(scene->composite(0)->linear_velocity_m_s.z, 1, 1e-6);
    EXPECT_NEAR(length(scene->state(3).position_m - scene->state(2).position_m), 1, 1e-6);
}

TEST(Composites, ErrorsSayWhatIsWrong) {
    auto scene = make_scene();
    need(scene->add_body({.id = 1, .position_m = {0, 0, 1}}));
    need(scene->add_body({.id = 2, .position_m = {2, 0, 1}}));
    EXPECT_EQ(scene->connect(1, 7).error().problem, "there is no body 7");
    EXPECT_EQ(scene->release(7, 1).error().problem, "there is no body 7");
    EXPECT_EQ(scene->connect(1, 1).error().problem, "body 1 cannot be connected to itself");
    need(scene->connect(1, 2)), need(scene->connect(2, 1));
    EXPECT_EQ(scene->connected_to(1).size(), 1u);
    need(scene->release(1, 2)), need(scene->release(1, 2));
    EXPECT_FALSE(scene->connected(1, 2));
    for (const EngineKind engine : {EngineKind::Hash, EngineKind::Ode}) {
        Settings settings;
        settings.engine = engine;
        auto other = make_scene(settings);
        need(other->add_body({.id = 1, .position_m = {0, 0, 1}}));
        need(other->add_body({.id = 2, .position_m = {2, 0, 1}}));
        EXPECT_EQ(other->connect(1, 2).error().problem, std::string("bodies 1 and 2 cannot be connected (the engine ") +
                                                            (engine == EngineKind::Hash ? "Hash" : "Ode") + " has no composites)");
    }
}

TEST(Composites, ADividedWorldIsSharedBefore) {
    auto scene = make_scene();
    need(scene->add_body({.id = 1, .position_m = {0, 0, 1}}));
    need(scene->add_body({.id = 2, .position_m = {1, 0, 1}}));
    const Subdomain part(*scene, [](BlockCoordinates) { return 0; }, 0, 1);
    EXPECT_EQ(scene->connect(1, 2).error().problem, "bodies 1 and 2 cannot be connected (the world is divided)");
    EXPECT_FALSE(scene->connected(1, 2));
}

TEST(Composites, AFailedStepChangesNothing) {
    auto scene = scene_on_plane();
    add_row(*scene, 0, 30, {0, 0, 0.7});
    Workers workers(1);
    run(*scene, 20, 2, workers);
    const Digest before = scene->digest();
    const CompositeState composite = *scene->composite(0);
    need(scene->set_wrench(7, {1e9, 0, 0}, {}));
    EXPECT_FALSE(scene->step(kTick, 2, workers));
    EXPECT_EQ(scene->digest(), before);
    EXPECT_EQ(scene->composite(0)->centre_m, composite.centre_m);
    EXPECT_EQ(scene->composite(0)->linear_velocity_m_s, composite.linear_velocity_m_s);
    need(scene->set_wrench(7, {}, {}));
    run(*scene, 20, 2, workers);
}

}  // namespace
}  // namespace meld::physics
