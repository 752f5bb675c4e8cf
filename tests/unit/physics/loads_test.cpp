// What connections carry, against statics and mechanics, and how they break.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

const std::vector<Quat> kTurns{{}, turn_of(0.7, {1, 2, -1}), turn_of(2.1, {-3, 1, 2})};

std::vector<ConnectionPair> solve(Scene& scene, int threads = 1) {
    Workers workers(threads);
    return need(scene.solve_loads(workers));
}

// Balls in a row, each connected with the one before, from `first` on.
void add_beam(Scene& scene, BodyId first, int count, Vec3 where, Vec3 way, double mass = 1) {
    for (int i = 0; i < count; ++i) {
        need(scene.add_body({.id = first + BodyId(i), .position_m = where + double(i) * way, .mass_kg = mass}));
        if (i > 0) need(scene.connect(first + BodyId(i) - 1, first + BodyId(i)));
    }
}

TEST(Loads, OfACantileverFollowStatics) {
    for (const int count : {10, 50, 100})
        for (const Quat& turn : kTurns)
            for (const double rise : {0.0, 0.6}) {
                const double mass = 0.7, slope = std::asin(rise);
                auto scene = make_scene(settings_with(rotate(turn, {0, 0, -kGravity})));
                const Vec3 way = rotate(turn, {std::cos(slope), 0, std::sin(slope)});
                need(scene->add_body({.id = 1000, .position_m = {3, -2, 8}, .fixed = true}));
                add_beam(*scene, 0, count, Vec3{3, -2, 8} + way, way, mass);
                need(scene->connect(1000, 0));
                scene->want_loads();
                Workers workers(1);
                run(*scene, 4, 2, workers);
                EXPECT_TRUE(solve(*scene).empty());
                for (int k = 0; k < count; ++k) {
                    // Beyond this connection hang so many, and their centre is half of them away.
                    const ConnectionLoad at = k == 0 ? load(*scene, 1000, 0) : load(*scene, BodyId(k) - 1, BodyId(k));
                    const double beyond = count - k, weight = beyond * mass * kGravity;
                    EXPECT_NEAR(at.shear_n, weight * std::cos(slope), 1e-3 * weight) << count << ' ' << k;
                    EXPECT_NEAR(at.tension_n, -weight * rise, 1e-3 * weight) << count << ' ' << k;
                    EXPECT_NEAR(at.bending_nm, weight * std::cos(slope) * beyond / 2, 1e-3 * weight * beyond / 2) << count << ' ' << k;
                    EXPECT_NEAR(at.twist_nm, 0, 1e-3 * weight);
                }
            }
}

TEST(Loads, OfABeamOnTwoSupports) {
    // Fixed balls carry a row at both ends; each carries half of it.
    const int count = 20;
    auto scene = make_scene(settings_with({0, 0, -kGravity}, 0));
    for (const BodyId end : {0u, 1u}) need(scene->add_body({.id = 5000 + end, .position_m = {end * (count - 1.0), 0, 0}, .fixed = true}));
    add_beam(*scene, 0, count, {0, 0, 1}, {1, 0, 0});
    scene->want_loads();
    Workers workers(1);
    run(*scene, 240, 2, workers);
    solve(*scene);
    run(*scene, 24, 2, workers);
    solve(*scene);
    const double half = count * kGravity / 2, most = half * count / 4;
    for (int k = 0; k + 1 < count; ++k) {
        const ConnectionLoad at = load(*scene, BodyId(k), BodyId(k) + 1);
        EXPECT_NEAR(at.shear_n, std::abs(half - (k + 1) * kGravity), 1e-3 * half) << k;
        EXPECT_NEAR(at.bending_nm, half * (k + 0.5) - (k + 1) * kGravity * (k + 1) / 2.0, 1e-3 * most) << k;
        EXPECT_NEAR(at.tension_n, 0, 0.02 * half) << k;
    }
}

TEST(Loads, OfASpinningDumbbell) {
    for (const Quat& turn : kTurns)
        for (const double mass : {1.0, 3.0}) {
            auto scene = make_scene(settings_with({}));
            const Vec3 way = rotate(turn, {1, 0, 0}), spin = rotate(turn, {0, 0, 4});
            need(scene->add_body({.id = 0, .position_m = {}, .angular_velocity_rad_s = spin}));
            need(scene->add_body(
                {.id = 1, .position_m = way, .linear_velocity_m_s = cross(spin, way), .angular_velocity_rad_s = spin, .mass_kg = mass}));
            need(scene->connect(0, 1));
            scene->want_loads();
            Workers workers(1);
            run(*scene, 60, 2, workers);
            solve(*scene);
            // The centre is at mass/(1 + mass) of the way.
            const double tension = 16 * mass / (1 + mass);
            const ConnectionLoad at = load(*scene, 0, 1);
            EXPECT_NEAR(at.tension_n, tension, 1e-3 * tension);
            EXPECT_NEAR(at.shear_n, 0, 1e-4 * tension);
            EXPECT_NEAR(at.torque_nm(), 0, 1e-4 * tension);
        }
}

TEST(Loads, OfWhatFallsFreelyAreNone) {
    auto scene = make_scene();
    add_beam(*scene, 0, 12, {0, 0, 50}, {1, 0, 0}, 2);
    add_beam(*scene, 100, 5, {4, 1, 50}, {0, 1, 0}, 0.5);
    need(scene->connect(4, 100));
    scene->want_loads();
    Workers workers(1);
    run(*scene, 120, 2, workers);
    solve(*scene);
    EXPECT_EQ(scene->loads().size(), 16u);
    for (const CarriedLoad& each : scene->loads()) {
        EXPECT_NEAR(each.load.tearing_n() + std::abs(each.load.tension_n), 0, 1e-9);
        EXPECT_NEAR(each.load.torque_nm(), 0, 1e-9);
    }
}

TEST(Loads, OfAForceOnOneEnd) {
    // A force pulls a free row by its end: behind each connection it accelerates what is there.
    auto scene = make_scene(settings_with({}));
    add_beam(*scene, 0, 10, {}, {1, 0, 0});
    need(scene->set_wrench(9, {30, 0, 0}, {}));
    scene->want_loads();
    Workers workers(1);
    run(*scene, 2, 2, workers);
    solve(*scene);
    for (BodyId k = 0; k < 9; ++k) EXPECT_NEAR(load(*scene, k, k + 1).tension_n, 3.0 * (k + 1), 1e-6);
    // Across, it turns the row too; a torque about the row's axis twists it.
    need(scene->set_wrench(9, {0, 12, 0}, {5, 0, 0}));
    run(*scene, 1, 2, workers);
    solve(*scene);
    // Acceleration 1.2 m/s^2, angular 12 * 4.5 / I, about the middle at 4.5: the shear is what the part before needs.
    const double inertia = 10 * 0.1 + 82.5, turning = 54 / inertia;
    for (BodyId k = 0; k < 9; ++k) {
        double shear = 0;
        for (BodyId i = 0; i <= k; ++i) shear += 1.2 + turning * (i - 4.5);
        EXPECT_NEAR(load(*scene, k, k + 1).shear_n, std::abs(shear), 1e-3) << k;
        EXPECT_NEAR(load(*scene, k, k + 1).twist_nm, 0.5 * (k + 1), 1e-3) << k;
    }
}

TEST(Loads, OfRandomTreesFollowNewtonAndEuler) {
    // Bodies of several sizes and masses in a tree that nothing holds, pushed and twisted at random: what a connection carries is what the
    // part behind it needs for its acceleration, less what acts there.
    std::mt19937 random(17);
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vector = [&] { return Vec3{unit(random), unit(random), unit(random)}; };
    for (const BodyId count : {2u, 5u, 40u, 150u}) {
        auto scene = make_scene(settings_with({}));
        std::vector<BodyId> parent(count);
        std::vector<Vec3> place(count), force(count), torque(count);
        std::vector<double> mass(count), radius(count);
        for (BodyId id = 0; id < count; ++id) {
            parent[id] = id == 0 ? 0 : BodyId(random() % id);
            mass[id] = double(float(1 + 0.8 * unit(random))), radius[id] = 0.4 + 0.1 * unit(random);
            const Vec3 way = vector();
            if (id > 0) place[id] = place[parent[id]] + ((radius[id] + radius[parent[id]]) / length(way)) * way;
            need(scene->add_body({.id = id, .position_m = place[id], .radius_m = radius[id], .mass_kg = mass[id]}));
            if (id > 0) need(scene->connect(parent[id], id));
            force[id] = 10.0 * vector(), torque[id] = 10.0 * vector();
            need(scene->set_wrench(id, force[id], torque[id]));
        }
        // Bodies overlap, but within a composite nothing touches.
        scene->want_loads();
        Workers workers(1);
        ASSERT_TRUE(scene->step(1e-6, 1, workers));
        solve(*scene);
        double total = 0;
        Vec3 centre, push, turn;
        for (BodyId id = 0; id < count; ++id) total += mass[id], centre = centre + mass[id] * place[id], push = push + force[id];
        centre = (1 / total) * centre;
        for (BodyId id = 0; id < count; ++id) turn = turn + torque[id] + cross(place[id] - centre, force[id]);
        const Vec3 acceleration = (1 / total) * push, turning = inverse(scene->composite(0)->inertia_kg_m2) * turn;
        std::vector<Vec3> lacks(count), lacks_torque(count);
        for (BodyId id = count; id-- > 1;) {
            const Vec3 needs = mass[id] * (acceleration + cross(turning, place[id] - centre)) - force[id];
            lacks[id] = lacks[id] + needs;
            lacks_torque[id] = lacks_torque[id] + 0.4 * mass[id] * radius[id] * radius[id] * turning - torque[id];
            const BodyId up = parent[id];
            const Vec3 along = (1 / length(place[id] - place[up])) * (place[id] - place[up]);
            const ConnectionLoad at = load(*scene, up, id);
            const double scale = 10 * std::sqrt(double(count));
            EXPECT_NEAR(at.tension_n, dot(lacks[id], -along), 1e-4 * scale) << count << ' ' << id;
            EXPECT_NEAR(at.shear_n, length(cross(lacks[id], along)), 1e-4 * scale) << count << ' ' << id;
            const Vec3 about = lacks_torque[id] + cross(radius[id] * along, lacks[id]);
            EXPECT_NEAR(at.torque_nm(), length(about), 1e-3 * scale) << count << ' ' << id;
            lacks[up] = lacks[up] + lacks[id];
            lacks_torque[up] = lacks_torque[up] + lacks_torque[id] + cross(place[id] - place[up], lacks[id]);
        }
    }
}

TEST(Loads, OfARingSplitBySymmetry) {
    for (const Quat& turn : kTurns) {
        const int count = 12;
        const double radius = 0.5 / std::sin(std::numbers::pi / count);
        auto scene = make_scene(settings_with(rotate(turn, {0, 0, -kGravity})));
        for (int i = 0; i < count; ++i) {
            const double angle = 2 * std::numbers::pi * i / count;
            need(scene->add_body(
                {.id = BodyId(i), .position_m = rotate(turn, {radius * std::sin(angle), 0, radius * std::cos(angle)}), .fixed = i == 0}));
            if (i > 0) need(scene->connect(BodyId(i) - 1, BodyId(i)));
        }
        need(scene->connect(count - 1, 0));
        scene->want_loads();
        Workers workers(1);
        run(*scene, 3, 2, workers);
        solve(*scene);
        for (int i = 0; i < count / 2; ++i) {
            const ConnectionLoad left = load(*scene, BodyId(i), BodyId(i) + 1),
                                 right = load(*scene, BodyId((count - i) % count), BodyId(count - i - 1));
            EXPECT_NEAR(left.tension_n, right.tension_n, 1e-6) << i;
            EXPECT_NEAR(left.shear_n, right.shear_n, 1e-6) << i;
            EXPECT_NEAR(left.bending_nm, right.bending_nm, 1e-6) << i;
            EXPECT_NEAR(left.twist_nm, 0, 1e-6) << i;
        }
        // Each half of the ring hangs on one connection of the fixed ball: along it and across it the forces add up to the weight.
        const ConnectionLoad top = load(*scene, 0, 1), bottom = load(*scene, 5, 6);
        const double lean = std::numbers::pi / count;
        const double down = std::abs(top.tension_n) * std::sin(lean) + top.shear_n * std::cos(lean),
                     other = std::abs(-std::abs(top.tension_n) * std::sin(lean) + top.shear_n * std::cos(lean));
        EXPECT_TRUE(std::abs(down - 5.5 * kGravity) < 1e-6 || std::abs(other - 5.5 * kGravity) < 1e-6) << down << ' ' << other;
        // The lowest ball hangs by half its weight on each side.
        EXPECT_GT(std::hypot(bottom.tension_n, bottom.shear_n), kGravity / 2 - 1e-6);
    }
}

TEST(Loads, BreakACantileverAtItsRootAndNowhereElse) {
    for (const int count : {10, 50}) {
        // A limit that the root exceeds and the next connection does not.
        const double root = kGravity * count * count / 2.0, next = kGravity * (count - 1) * (count - 1) / 2.0;
        for (const bool breaks : {false, true}) {
            auto scene = make_scene();
            need(scene->add_body({.id = 1000, .position_m = {-1, 0, 3}, .fixed = true}));
            add_beam(*scene, 0, count, {0, 0, 3}, {1, 0, 0});
            need(scene->connect(1000, 0));
            // The weaker end counts.
            need(scene->set_breaking(1000, {.torque_nm = 10 * root}));
            for (BodyId i = 0; i < BodyId(count); ++i)
                need(scene->set_breaking(i, {.torque_nm = breaks ? (root + next) / 2 : 1.01 * root}));
            Workers workers(1);
            run(*scene, 1, 2, workers);
            const std::vector<ConnectionPair> broken = solve(*scene);
            EXPECT_EQ(broken, breaks ? std::vector<ConnectionPair>({{0, 1000}}) : std::vector<ConnectionPair>()) << count;
            EXPECT_EQ(scene->connection_count(), std::size_t(count) - (breaks ? 1 : 0));
            // The part that falls carries nothing any more, as of the same moment.
            if (breaks) {
                EXPECT_NEAR(load(*scene, 0, 1).torque_nm(), 0, 1e-6 * root);
            }
            run(*scene, 30, 2, workers);
            EXPECT_TRUE(solve(*scene).empty());
            EXPECT_NEAR(scene->state(BodyId(count) - 1).position_m.z, breaks ? 3 - 0.5 * kGravity / 64 * 1.0 : 3, breaks ? 0.01 : 1e-9);
        }
    }
}

TEST(Loads, BreakOneAfterTheOtherAndAtMostSixteen) {
    // A row that hangs down breaks where the most hangs.
    auto scene = make_scene();
    need(scene->add_body({.id = 1000, .position_m = {0, 0, 60}, .fixed = true}));
    add_beam(*scene, 0, 40, {0, 0, 59}, {0, 0, -1});
    need(scene->connect(1000, 0));
    for (BodyId i = 0; i < 40; ++i) need(scene->set_breaking(i, {.force_n = 39.5 * kGravity}));
    Workers workers(1);
    run(*scene, 1, 2, workers);
    EXPECT_EQ(solve(*scene), std::vector<ConnectionPair>({{0, 1000}}));
    // Pressed from both ends it does not break, whatever the limits; pulled it does.
    for (BodyId i = 0; i < 40; ++i) need(scene->set_breaking(i, {.force_n = 1}));
    need(scene->set_wrench(0, {0, 0, -500}, {})), need(scene->set_wrench(39, {0, 0, 500}, {}));
    run(*scene, 1, 2, workers);
    EXPECT_TRUE(solve(*scene).empty());
    // A row that nothing holds, each pulled away from the middle by 10 N more than the one before: pieces break in two until each body is
    // alone, but at most sixteen connections of a composite at once.
    auto torn = make_scene(settings_with({}));
    add_beam(*torn, 0, 40, {}, {0, 0, -1});
    for (BodyId i = 0; i < 40; ++i) need(torn->set_breaking(i, {.force_n = 1})), need(torn->set_wrench(i, {0, 0, 195 - 10.0 * i}, {}));
    for (const std::size_t count : {16u, 23u, 0u}) {
        run(*torn, 1, 2, workers);
        const std::vector<ConnectionPair> broken = solve(*torn);
        EXPECT_EQ(broken.size(), count);
        EXPECT_EQ(std::ranges::binary_search(broken, ConnectionPair(19, 20)), count == 16);
    }
}

TEST(Loads, OfAnImpactAreItsMean) {
    // A ball hits the end of a cantilever across it, without gravity and without bouncing: its momentum has gone through the root.
    for (const double restitution : {0.0, 0.5}) {
        auto scene = make_scene(settings_with({}));
        const std::uint8_t material = need(scene->add_material({.friction = 0, .restitution = float(restitution)}));
        need(scene->add_body({.id = 1000, .position_m = {-1, 0, 0}, .fixed = true}));
        for (BodyId i = 0; i < 5; ++i) {
            need(scene->add_body({.id = i, .position_m = {double(i), 0, 0}, .material = material}));
            need(scene->connect(i == 0 ? 1000 : i - 1, i));
        }
        need(scene->add_body({.id = 10, .position_m = {4, 0, 1.1}, .linear_velocity_m_s = {0, 0, -3}, .mass_kg = 2, .material = material}));
        scene->want_loads();
        Workers workers(1);
        double momentum = 0, moment = 0;
        for (int tick = 0; tick < 30; ++tick) {
            run(*scene, 2, 2, workers);
            solve(*scene);
            momentum += load(*scene, 1000, 0).shear_n * 2 * kTick;
            moment += load(*scene, 1000, 0).bending_nm * 2 * kTick;
        }
        const double passed = 2 * (3 + scene->state(10).linear_velocity_m_s.z);
        EXPECT_GT(passed, 5.5);
        EXPECT_NEAR(momentum, passed, 0.01 * passed) << restitution;
        EXPECT_NEAR(moment, 4.5 * passed, 0.01 * 4.5 * passed) << restitution;
    }
}

TEST(Loads, OfASleepingCompositeStay) {
    auto scene = scene_on_plane();
    add_beam(*scene, 0, 6, {0, 0, 0.5}, {0, 0, 1});
    need(scene->add_body({.id = 50, .position_m = {1, 0, 0.5}}));
    need(scene->connect(0, 50));
    scene->want_loads();
    Workers workers(1);
    run(*scene, 400, 2, workers);
    solve(*scene);
    EXPECT_TRUE(scene->asleep(0));
    const ConnectionLoad before = load(*scene, 0, 1);
    EXPECT_NEAR(before.tension_n, -5 * kGravity, 0.05);
    run(*scene, 10, 2, workers);
    solve(*scene);
    EXPECT_EQ(load(*scene, 0, 1), before);
    // Released, the others keep what they carried until it moves.
    need(scene->release(0, 50));
    solve(*scene);
    EXPECT_FALSE(scene->load(0, 50));
    EXPECT_EQ(load(*scene, 0, 1), before);
}

TEST(Loads, ErrorsSayWhatIsWrong) {
    auto scene = make_scene();
    need(scene->add_body({.id = 1}));
    for (const double limit : {0.0, -1.0, std::nan("")})
        for (const BreakingLimits limits : {BreakingLimits{.force_n = limit}, BreakingLimits{.torque_nm = limit}}) {
            const auto set = scene->set_breaking(1, limits);
            ASSERT_FALSE(set);
            EXPECT_NE(set.error().message().find("which is not above 0"), std::string::npos);
        }
    EXPECT_FALSE(scene->set_breaking(2, {}));
}

}  // namespace
}  // namespace meld::physics
