// Obstacles of all shapes that bodies have, turned about any axis, on one and on several workers and processes, and in ODE.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "tests/unit/physics/divided_world.h"
#include "tests/unit/physics/snapshots.h"
#include "tests/unit/physics/two_engines.h"

namespace meld::physics::solid_obstacles {
namespace {

const Quat kAlongX = turn_of(std::numbers::pi / 2, {0, 1, 0});
constexpr double kEdge_m = 0.02;

ShapePart part(const BodyShape& shape, Vec3 at, Quat turn = {}) { return {shape.core_m, shape.rounding_m, at, turn, shape.volume_m3()}; }

// Two posts and what lies on them, around the origin.
BodyShape gate() {
    return compound_of({part(cylinder_shape(0.3, 2, kEdge_m), {-1.2, 0, 0}), part(cylinder_shape(0.3, 2, kEdge_m), {1.2, 0, 0}),
                        part(box_shape({3, 1, 0.4}, kEdge_m), {0, 0, 1.2})})
        .shape;
}

// An obstacle, and how far above its centre a body lies on it.
struct Kind {
    std::string name;
    Solid solid;
    double top_m;
};
std::vector<Kind> kinds() {
    const BodyShape frame = gate();
    return {{"sphere", {{{}, 3}, {}, {}}, 3},
            {"capsule", {capsule_shape(1, 8), {}, kAlongX}, 1},
            {"cylinder on its side", {cylinder_shape(1.5, 8, kEdge_m), {}, kAlongX}, 1.5},
            {"cylinder that stands", {cylinder_shape(2, 3, kEdge_m), {}, turn_of(0.7, {0, 0, 1})}, 1.5},
            {"sharp cylinder", {cylinder_shape(2, 3, 0), {}, {}}, 1.5},
            {"rounded box", {box_shape({3, 4, 2}, 0.3), {}, {}}, 1},
            {"sharp box", {box_shape({3, 4, 2}, 0), {}, {}}, 1},
            {"gate", {frame, {}, {}}, frame.parts[2].at_m.z + 0.2}};
}

struct Faller {
    std::string name;
    std::optional<BodyShape> shape;
    double below_m;
};
const std::vector<Faller> kFallers = {
    {"ball", std::nullopt, 0.5},
    {"cube", box_shape({0.8, 0.8, 0.8}, kEdge_m), 0.4},
    {"cylinder", cylinder_shape(0.4, 0.6, kEdge_m), 0.3},
    {"compound",
     compound_of({part(box_shape({0.8, 0.8, 0.4}, kEdge_m), {0, 0, -0.2}), part(cylinder_shape(0.2, 0.4, kEdge_m), {0, 0, 0.2})}).shape,
     0}};

double below_of(const Faller& faller) {
    return faller.shape && faller.shape->is_compound() ? 0.2 - faller.shape->parts[0].at_m.z : faller.below_m;
}

TEST(SolidObstacles, BodiesLieOnTopOfThem) {
    const Vec3 centre{3, -2, 5};
    for (const EngineKind engine : {EngineKind::Blocks, EngineKind::Ode})
        for (Kind kind : kinds())
            for (const Faller& faller : kFallers) {
                auto scene = make_scene(
                    {.engine = engine, .solver = engine == EngineKind::Ode ? SolverSettings::pgs20() : SolverSettings{}, .sleep_ticks = 0});
                kind.solid.centre = centre;
                need(scene->add_obstacle(kind.solid, 0));
                const double height = centre.z + kind.top_m + below_of(faller);
                need(scene->add_body({.id = 0, .position_m = {centre.x, centre.y, height + 0.01}, .shape = faller.shape}));
                need(scene->add_body({.id = 1, .position_m = {centre.x + 9, centre.y, height}, .shape = faller.shape}));
                Workers workers(1);
                run(*scene, 60, 2, workers);
                EXPECT_NEAR(scene->state(0).position_m.z, height, engine == EngineKind::Ode ? 0.02 : 3e-3)
                    << kind.name << ", " << faller.name;
                EXPECT_LT(scene->state(1).position_m.z, height - 0.2) << kind.name;
                const auto contacts = scene->contacts();
                ASSERT_FALSE(contacts.empty()) << kind.name << ", " << faller.name;
                for (const ContactReport& contact : contacts) EXPECT_EQ(contact.touch, (Touch{0, 0, true}));
            }
}

// As a fixed body of the same form does it, wherever and however it is met.
TEST(SolidObstacles, DeflectAsFixedBodiesDo) {
    for (Kind kind : kinds())
        for (const Faller& faller : kFallers) {
            kind.solid.orientation = product(turn_of(0.9, {1, 2, 0.5}), kind.solid.orientation);
            const auto end = [&](bool fixed) {
                auto scene = make_scene({.gravity_m_s2 = {}, .sleep_ticks = 0});
                if (fixed)
                    need(scene->add_body({.id = 1,
                                          .orientation = kind.solid.orientation,
                                          .radius_m = kind.solid.shape.radius_m(),
                                          .fixed = true,
                                          .shape = kind.solid.shape}));
                else
                    need(scene->add_obstacle(kind.solid, 0));
                need(scene->add_body({.id = 0,
                                      .position_m = {7, 1, 2},
                                      .linear_velocity_m_s = {-8, -1, -2.5},
                                      .angular_velocity_rad_s = {1, 2, 0},
                                      .shape = faller.shape}));
                Workers workers(1);
                run(*scene, 240, 2, workers);
                return scene->state(0);
            };
            const BodyState at_obstacle = end(false), at_body = end(true);
            EXPECT_LT(length(at_obstacle.position_m - at_body.position_m), 0.05) << kind.name << ", " << faller.name;
            // Some fly through the gate.
            if (!kind.solid.shape.is_compound()) {
                EXPECT_GT(length(at_obstacle.linear_velocity_m_s - Vec3{-8, -1, -2.5}), 0.5) << kind.name << ", " << faller.name;
            }
        }
}

// On a slope in any direction: a cube rests up to the angle of friction and slides faster beyond it, a ball rolls.
TEST(SolidObstacles, TiltedBoxesAreSlopes) {
    const double friction = 0.4, rests = std::atan(friction);
    for (const double rounding : {0.0, 0.2})
        for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{1, 2, 0}, Vec3{-1, 0.3, 0}})
            for (const double angle : {rests - 0.01, rests + 0.05}) {
                auto scene = make_scene({.sleep_ticks = 0});
                const auto rough = need(scene->add_material({.friction = static_cast<float>(friction)}));
                const Quat turn = turn_of(angle, axis);
                if (rounding > 0)
                    need(scene->add_obstacle(Solid{box_shape({30, 30, 2}, rounding), {1, 2, 3}, turn}, rough));
                else
                    need(scene->add_obstacle(Box{{1, 2, 3}, {30, 30, 2}, turn}, rough));
                const Vec3 up = rotate(turn, {0, 0, 1}), middle{1, 2, 3};
                need(scene->add_body({.id = 0,
                                      .position_m = middle + 1.5 * up + rotate(turn, {3, 0, 0}),
                                      .orientation = turn,
                                      .material = rough,
                                      .shape = box_shape({1, 1, 1}, kEdge_m)}));
                need(scene->add_body({.id = 1, .position_m = middle + 1.5 * up - rotate(turn, {3, 0, 0}), .material = rough}));
                Workers workers(1);
                run(*scene, 240, 2, workers);
                const double slides = angle < rests ? 0 : kGravity * (std::sin(angle) - friction * std::cos(angle));
                EXPECT_NEAR(speed(*scene, 0), slides, 0.02) << rounding << ", " << angle;
                EXPECT_NEAR(speed(*scene, 1), 5.0 / 7 * kGravity * std::sin(angle), 0.02) << rounding << ", " << angle;
                for (const BodyId body : {0u, 1u})
                    EXPECT_NEAR(dot(scene->state(body).position_m - middle, up), 1.5, 3e-3) << rounding << ", " << angle;
            }
}

// On two rails it rolls about the line between the points where it touches them, h below its middle: a = g sin(slope) / (1 + 2/5 (r/h)^2).
TEST(SolidObstacles, ABallRollsBetweenTwoCylinders) {
    const double rail = 0.4, apart = 0.6, ball = 0.5, slope = 0.3, across = std::asin(apart / (rail + ball));
    const double height = (rail + ball) * std::cos(across), h = ball * std::cos(across);
    const double expected = kGravity * std::sin(slope) / (1 + 0.4 * ball * ball / (h * h));
    const Quat tilt = turn_of(slope, {0, 1, 0});
    for (const bool compound : {false, true}) {
        BothEngines both(1e-3);
        both.each([&](Scene& scene) {
            const BodyShape bar = cylinder_shape(rail, 30, kEdge_m);
            if (compound) {
                need(scene.add_obstacle(
                    Solid{compound_of({part(bar, {0, -apart, 0}, kAlongX), part(bar, {0, apart, 0}, kAlongX)}).shape, {}, tilt}, 0));
            } else {
                for (const double side : {-apart, apart}) need(scene.add_obstacle(Solid{bar, {0, side, 0}, product(tilt, kAlongX)}, 0));
            }
            need(scene.add_body({.id = 0, .position_m = height * rotate(tilt, {0, 0, 1})}));
        });
        both.go(1);
        both.each([&](Scene& scene) {
            const BodyState state = scene.state(0);
            const Vec3 own = rotate(conjugate(tilt), state.position_m);
            EXPECT_NEAR(own.z, height, 2e-3) << compound;
            EXPECT_NEAR(own.y, 0, 1e-3) << compound;
            EXPECT_NEAR(length(state.linear_velocity_m_s), expected, 0.01 * expected) << compound;
        });
        EXPECT_LT(both.apart(0), 0.01);
    }
}

TEST(SolidObstacles, RaysMeetThemWhereTheyAre) {
    const auto first = [](const Solid& solid, const Ray& ray) {
        Obstacles all;
        need(all.add(solid, 0));
        return all.first_on(0, ray);
    };
    // From ten metres away to the other side.
    const auto metres = [&](const Solid& solid, Vec3 beside = {}) {
        const auto met = first(solid, {Vec3{10, 0, 0} + beside, {-20, 0, 0}});
        return met ? 20 * *met : -1;
    };
    EXPECT_NEAR(metres({{{}, 2}, {}, {}}), 8, 1e-9);
    EXPECT_NEAR(metres({{{}, 2}, {}, {}}, {0, 1.2, 0}), 8.4, 1e-9);
    EXPECT_NEAR(metres({capsule_shape(0.5, 4), {}, {}}), 9.5, 1e-9);
    EXPECT_NEAR(metres({capsule_shape(0.5, 4), {}, kAlongX}), 8, 1e-9);
    EXPECT_NEAR(metres({cylinder_shape(1, 3, 0), {}, {}}), 9, 1e-9);
    EXPECT_NEAR(metres({cylinder_shape(1, 3, 0), {}, kAlongX}), 8.5, 1e-9);
    EXPECT_NEAR(metres({cylinder_shape(1, 3, 0), {}, turn_of(std::numbers::pi / 4, {0, 1, 0})}), 10 - std::sqrt(2), 1e-9);
    EXPECT_NEAR(metres({box_shape({2, 2, 2}, 0.1), {}, turn_of(std::numbers::pi / 4, {0, 0, 1})}), 10 - 0.9 * std::sqrt(2) - 0.1, 1e-9);
    EXPECT_NEAR(metres({gate(), {}, {}}), 8.5, 1e-9);
    EXPECT_EQ(metres({gate(), {}, turn_of(std::numbers::pi / 2, {0, 0, 1})}), -1);
    EXPECT_EQ(metres({{{}, 2}, {}, {}}, {0, 2.1, 0}), -1);
    EXPECT_EQ(first({{{}, 2}, {}, {}}, {{1, 0, 0}, {9, 0, 0}}), 0);
}

// Whatever a step's way is: it hits what is thinner than that where its way leads.
TEST(SolidObstacles, FastBallsDoNotPassThem) {
    Workers workers(1);
    const BodyShape slab = box_shape({60, 60, 0.1}, 0.01);
    const std::pair<const char*, BodyShape> walls[] = {
        {"slab", slab},
        {"cylinder", cylinder_shape(30, 0.1, 0.01)},
        {"two slabs",
         compound_of({part(box_shape({30, 60, 0.1}, 0.01), {-15, 0, 0}), part(box_shape({30, 60, 0.1}, 0.01), {15, 0, 0})}).shape}};
    for (const double speed : {20.0, 150.0, 900.0})
        for (const double start : {2.0, 6.0, 11.3})
            for (const auto& [name, wall] : walls) {
                auto scene = make_scene({.gravity_m_s2 = {}});
                const auto material = need(scene->add_material({.friction = 0, .restitution = 1}));
                need(scene->add_obstacle(Solid{wall, {}, turn_of(0.4, {0, 0, 1})}, material));
                need(scene->add_body(
                    {.id = 0, .position_m = {1, 0, start}, .linear_velocity_m_s = {0.4 * speed, 0, -speed}, .material = material}));
                double nearest = start;
                for (int tick = 0; tick < static_cast<int>(2 * start / speed / kTick) + 3; ++tick) {
                    need(scene->step(kTick, 2, workers));
                    nearest = std::min(nearest, scene->state(0).position_m.z);
                }
                EXPECT_GT(nearest, 0.54) << speed << " from " << start << " onto a " << name;
                EXPECT_NEAR(scene->state(0).linear_velocity_m_s.z, speed, 0.01 * speed) << speed << " from " << start << " onto a " << name;
            }
}

TEST(SolidObstacles, AreRefusedIfTheyCannotBeAndRefuseWhatBeginsInThem) {
    auto scene = make_scene();
    EXPECT_FALSE(scene->add_obstacle(Solid{{{}, 0}, {}, {}}, 0));
    EXPECT_FALSE(scene->add_obstacle(Solid{{{}, 1}, {}, {0, 0, 0, 0}}, 0));
    EXPECT_FALSE(scene->add_obstacle(Solid{{{}, 1}, {std::nan(""), 0, 0}, {}}, 0));
    need(scene->add_obstacle(Solid{cylinder_shape(4, 8, 0), {0, 0, 0}, {}}, 0));
    need(scene->add_obstacle(Solid{gate(), {20, 0, 0}, {}}, 0));
    const auto problem = [&](Vec3 at, std::optional<BodyShape> shape = {}) {
        const auto added = scene->add_body({.id = 7, .position_m = at, .shape = shape});
        return added ? std::string("none") : added.error().problem;
    };
    EXPECT_EQ(problem({3, 0, 0}), "body 7 is 1.5 m deep in obstacle 0, a cylinder, more than 50 % of its diameter");
    EXPECT_TRUE(
        problem({3, 0, 0}, box_shape({1, 1, 1}, kEdge_m)).ends_with("m deep in obstacle 0, a cylinder, more than 50 % of its diameter"));
    EXPECT_TRUE(problem({20 - 1.2, 0, 0}).starts_with("body 7 is 0.8 m deep in obstacle 1, a compound"));
    // Between the posts.
    EXPECT_EQ(problem({20, 0, -0.5}), "none");
}

// All kinds of bodies fall onto all kinds of obstacles and each other.
void add_course(Scene& scene) {
    double x = 0;
    for (Kind kind : kinds()) {
        kind.solid.centre = {x, 2, 0};
        kind.solid.orientation = product(turn_of(0.3 + x, {1, 0.2 * x, 0.4}), kind.solid.orientation);
        need(scene.add_obstacle(kind.solid, 0));
        x += 2.2;
    }
    need(scene.add_obstacle(Plane{{0, 0, 1}, -2}, 0));
    need(scene.add_obstacle(Box{{8, -2, 0}, {20, 1, 3}, turn_of(0.5, {1, 1, 0})}, 0));
}
void add_fallers(Scene& scene, const std::function<bool(BodyId)>& mine) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2), speed(-2, 2);
    for (BodyId id = 0; id < 160; ++id) {
        BodySpec spec{.id = id,
                      .position_m = {1.6 * (id % 10) + jitter(random), 1.6 * (id / 10 % 4), 6 + 1.6 * (id / 40)},
                      .linear_velocity_m_s = {speed(random), speed(random), speed(random)},
                      .angular_velocity_rad_s = {speed(random), speed(random), speed(random)},
                      .shape = kFallers[id % 4].shape};
        if (mine(id)) need(scene.add_body(spec));
    }
}
void furnish_course(Scene& scene, const std::function<bool(BodyId)>& mine) { add_course(scene), add_fallers(scene, mine); }

TEST(SolidObstacles, SameBitsForAnyNumberOfWorkersAndAfterASnapshot) {
    for (const EngineKind engine : {EngineKind::Blocks, EngineKind::Ode}) {
        Settings settings = settings_for_shapes();
        settings.engine = engine;
        if (engine == EngineKind::Ode) settings.solver = SolverSettings::pgs20();
        const auto empty = [&] {
            auto scene = make_scene(settings);
            add_course(*scene);
            return scene;
        };
        expect_same_bits(empty, [](Scene& scene) { add_fallers(scene, [](BodyId) { return true; }); });
    }
}

TEST(SolidObstacles, SameBitsInADividedWorld) {
    auto whole = make_scene(settings_for_shapes());
    furnish_course(*whole, [](BodyId) { return true; });
    Workers workers(1);
    run(*whole, 200, 2, workers);
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    Divided divided(3, scattered, furnish_course, settings_for_shapes());
    for (int tick = 0; tick < 200; ++tick) divided.tick();
    EXPECT_EQ(divided.digest(), whole->digest());
    EXPECT_GT(divided.rebuilds, 3);
}

}  // namespace
}  // namespace meld::physics::solid_obstacles
