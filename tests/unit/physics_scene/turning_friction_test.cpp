// Friction against rolling and spinning against mechanics: how far a ball rolls, on which slopes it stands, how long it spins; the same of
// cylinders and composites, of two bodies against each other, and of ODE.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/unit/physics/divided_world.h"
#include "tests/unit/physics/scenes.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics {
namespace {

constexpr double kPatch = 0.01;  // m

class TurningFrictionOf : public testing::Test {
  protected:
    // A scene on a plane that resists rolling and spinning; gravity leans by an angle towards x.
    static std::unique_ptr<Scene> on_rough_plane(Settings settings = {}, double angle = 0) {
        settings.gravity_m_s2 = {kGravity * std::sin(angle), 0, -kGravity * std::cos(angle)};
        auto scene = make_scene(settings);
        const auto rough = need(scene->add_material({.rolling_m = static_cast<float>(kPatch), .spinning_m = static_cast<float>(kPatch)}));
        need(scene->add_obstacle(Plane{}, rough));
        return scene;
    }
    // How far body 0 comes along x until it stops, and whether it has stopped.
    double way(Scene& scene, int ticks) {
        const double before = scene.state(0).position_m.x;
        run(scene, ticks, 2, workers_);
        EXPECT_LT(speed(scene, 0), 5e-3);
        return scene.state(0).position_m.x - before;
    }
    static Settings settings_of(EngineKind engine, SolverMode mode) {
        Settings settings;
        settings.engine = engine;
        if (mode == SolverMode::Pgs) settings.solver = SolverSettings::pgs20();
        return settings;
    }

    Workers workers_{1};
};

// v^2 / 2 over the deceleration 5/7 g r/R, in both modes and in ODE.
TEST_F(TurningFrictionOf, ABallRollsAsFarAsItsPatchLetsIt) {
    for (const Settings& settings : {settings_of(EngineKind::Blocks, SolverMode::Soft), settings_of(EngineKind::Blocks, SolverMode::Pgs),
                                     settings_of(EngineKind::Ode, SolverMode::Pgs)}) {
        auto scene = on_rough_plane(settings);
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .linear_velocity_m_s = {1, 0, 0}, .angular_velocity_rad_s = {0, 2, 0}}));
        const double expected = 1 / (2 * 5.0 / 7 * kGravity * kPatch / 0.5);
        EXPECT_NEAR(way(*scene, 2400), expected, 0.02 * expected);
    }
}

TEST_F(TurningFrictionOf, ASmallBallRollsAsFarInDiameters) {
    auto scene = on_rough_plane();
    need(scene->add_body({.id = 0,
                          .position_m = {0, 0, 0.1},
                          .linear_velocity_m_s = {0.5, 0, 0},
                          .angular_velocity_rad_s = {0, 5, 0},
                          .radius_m = 0.1,
                          .mass_kg = 0.01}));
    const double expected = 0.25 / (2 * 5.0 / 7 * kGravity * kPatch / 0.1);
    EXPECT_NEAR(way(*scene, 1200), expected, 0.02 * expected);
}

// It stands where the slope is less than r/R, awake for ten seconds, and rolls where it is more, at 5/7 of what is left of the pull.
TEST_F(TurningFrictionOf, ABallStandsOnSlopesBelowItsPatch) {
    for (const double share : {0.5, 0.95, 1.1, 2.0}) {
        const double slope = share * kPatch / 0.5, angle = std::atan(slope);
        auto scene = on_rough_plane({.sleep_ticks = 0}, angle);
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}}));
        run(*scene, 2400, 2, workers_);
        const double pull = kGravity * (std::sin(angle) - kPatch / 0.5 * std::cos(angle));
        if (share < 1)
            EXPECT_LT(std::abs(scene->state(0).position_m.x), 1e-4) << share;
        else
            EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 5.0 / 7 * pull * 10, 0.02 * 5.0 / 7 * pull * 10) << share;
    }
}

// I w / (r m g): a ball, and a cylinder on its cap, whose face resists besides by friction; with sliding friction 0 by its patch alone.
TEST_F(TurningFrictionOf, ASpinStopsAfterTheTimeOfItsPatch) {
    for (const EngineKind engine : {EngineKind::Blocks, EngineKind::Ode}) {
        auto scene = on_rough_plane(settings_of(engine, SolverMode::Soft));
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .angular_velocity_rad_s = {0, 0, 2}}));
        const double time = 0.4 * 0.25 * 2 / (kPatch * kGravity);
        run(*scene, static_cast<int>(0.5 * time / kTick), 2, workers_);
        EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, 1, 0.02);
        run(*scene, static_cast<int>(0.52 * time / kTick), 2, workers_);
        EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, 0, 1e-3);
        EXPECT_LT(length(scene->state(0).position_m - Vec3{0, 0, 0.5}), 2e-3);
    }
    auto scene = make_scene();
    const auto smooth = need(scene->add_material({.friction = 0, .spinning_m = static_cast<float>(kPatch)}));
    need(scene->add_obstacle(Plane{}, smooth));
    need(scene->add_body(
        {.id = 0, .position_m = {0, 0, 0.5}, .angular_velocity_rad_s = {0, 0, 2}, .material = smooth, .shape = cylinder_shape(0.4, 1, 0)}));
    const double time = 0.5 * 0.16 * 2 / (kPatch * kGravity);
    run(*scene, static_cast<int>(0.5 * time / kTick), 2, workers_);
    EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, 1, 0.02);
    run(*scene, static_cast<int>(0.52 * time / kTick), 2, workers_);
    EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, 0, 1e-3);
}

// A cylinder on its side: v^2 / 2 over 2/3 g r/R; and on slopes as a ball.
TEST_F(TurningFrictionOf, ACylinderRollsAsFarAsItsPatchLetsIt) {
    const Quat lying = turn_of(std::numbers::pi / 2, {1, 0, 0});
    for (const SolverMode mode : {SolverMode::Soft, SolverMode::Pgs}) {
        auto scene = on_rough_plane(settings_of(EngineKind::Blocks, mode));
        need(scene->add_body({.id = 0,
                              .position_m = {0, 0, 0.5},
                              .orientation = lying,
                              .linear_velocity_m_s = {1, 0, 0},
                              .angular_velocity_rad_s = {0, 2, 0},
                              .shape = cylinder_shape(0.5, 1, 0.02)}));
        const double expected = 1 / (2 * 2.0 / 3 * kGravity * kPatch / 0.5);
        EXPECT_NEAR(way(*scene, 2400), expected, 0.02 * expected);
    }
    for (const double share : {0.9, 1.2}) {
        const double angle = std::atan(share * kPatch / 0.5);
        auto scene = on_rough_plane({.sleep_ticks = 0}, angle);
        need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .orientation = lying, .shape = cylinder_shape(0.5, 1, 0.02)}));
        run(*scene, 1200, 2, workers_);
        const double pull = kGravity * (std::sin(angle) - kPatch / 0.5 * std::cos(angle));
        if (share < 1)
            EXPECT_LT(std::abs(scene->state(0).position_m.x), 1e-3);
        else
            EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 2.0 / 3 * pull * 5, 0.03 * 2.0 / 3 * pull * 5);
    }
}

// A cube on its edge falls more slowly over it: it stands where its middle is less than the patch beside the edge.
TEST_F(TurningFrictionOf, ACubeStandsOnItsEdgeWithinThePatch) {
    for (const double lean : {0.5, 1.5}) {
        const double high = std::sqrt(0.5), angle = std::numbers::pi / 4 + lean * kPatch / high;
        auto scene = on_rough_plane({.sleep_ticks = 0});
        need(scene->add_body({.id = 0,
                              .position_m = {0, 0, high * std::cos(lean * kPatch / high)},
                              .orientation = turn_of(angle, {0, 1, 0}),
                              .shape = box_shape({1, 1, 1}, 0)}));
        run(*scene, 480, 2, workers_);
        const Vec3 up = rotate(scene->state(0).orientation, {0, 0, 1});
        const double leans = std::acos(std::clamp(up.z, -1.0, 1.0));
        if (lean < 1)
            EXPECT_NEAR(leans, angle, 0.005);
        else
            EXPECT_GT(std::abs(leans - angle), 0.5);
    }
}

// A dumbbell of two balls that are connected rolls about its long axis: with I = 2/5 m R^2 of each, as a ball does.
TEST_F(TurningFrictionOf, ACompositeRollsAsFarAsItsPatchLetsIt) {
    for (const bool cylinders : {false, true}) {
        auto scene = on_rough_plane();
        for (const BodyId id : {0u, 1u}) {
            BodySpec spec{
                .id = id, .position_m = {0, 1.0 * id, 0.5}, .linear_velocity_m_s = {1, 0, 0}, .angular_velocity_rad_s = {0, 2, 0}};
            if (cylinders) spec.shape = cylinder_shape(0.5, 1, 0.02), spec.orientation = turn_of(std::numbers::pi / 2, {1, 0, 0});
            need(scene->add_body(spec));
        }
        need(scene->connect(0, 1));
        const double expected = 1 / (2 * (cylinders ? 2.0 / 3 : 5.0 / 7) * kGravity * kPatch / 0.5);
        EXPECT_NEAR(way(*scene, 2400), expected, 0.02 * expected) << cylinders;
    }
}

// Two bodies that are pressed together and spin against each other come to the same spin; angular momentum is kept, and the faster one
// loses its part at the rate of the patch. Balls, cylinders face to face, one of each, and two composites.
TEST_F(TurningFrictionOf, TwoBodiesTakeEachOtherAlong) {
    for (const int kind : {0, 1, 2, 3}) {
        auto scene = make_scene({.gravity_m_s2 = {}, .sleep_ticks = 0});
        const auto smooth = need(scene->add_material({.friction = 0, .spinning_m = 0.05f}));
        const double press = 10;
        for (const BodyId id : {0u, 1u}) {
            BodySpec spec{
                .id = id, .position_m = {0, 0, 1.0 * id}, .angular_velocity_rad_s = {0, 0, id == 0 ? 4.0 : 0.0}, .material = smooth};
            if (kind == 1 || (kind == 2 && id == 1)) spec.shape = cylinder_shape(0.5, 1, 0);
            need(scene->add_body(spec));
            need(scene->set_wrench(id, {0, 0, id == 0 ? press : -press}, {}));
        }
        if (kind == 3) {
            for (const BodyId id : {2u, 3u}) {
                need(scene->add_body({.id = id,
                                      .position_m = {0, 0, id == 2 ? -1.0 : 2.0},
                                      .angular_velocity_rad_s = {0, 0, id == 2 ? 4.0 : 0.0},
                                      .material = smooth}));
                need(scene->connect(id - 2, id));
            }
        }
        const double before = scene->angular_momentum().z;
        const Vec3 momentum = scene->momentum();
        const double inertia = kind == 1 ? 0.125 : kind == 3 ? 0.2 : 0.1;
        run(*scene, 24, 2, workers_);
        EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, 4 - 0.05 * press * 0.1 / inertia, 0.02) << kind;
        run(*scene, 480, 2, workers_);
        EXPECT_NEAR(scene->state(0).angular_velocity_rad_s.z, scene->state(1).angular_velocity_rad_s.z, 1e-3) << kind;
        EXPECT_NEAR(scene->angular_momentum().z, before, 2e-3 * std::abs(before)) << kind;
        EXPECT_LT(length(scene->momentum() - momentum), 1e-3) << kind;
    }
}

// What a connection carries counts the torque: a wheel of two balls that spins on the ground twists its connection by half of that.
TEST_F(TurningFrictionOf, LoadsCountTheTorque) {
    auto scene = on_rough_plane({.sleep_ticks = 0});
    for (const BodyId id : {0u, 1u})
        need(scene->add_body({.id = id, .position_m = {0, 0, 0.5 + id}, .angular_velocity_rad_s = {0, 0, 20}}));
    need(scene->connect(0, 1));
    scene->want_loads();
    run(*scene, 48, 2, workers_);
    need(scene->solve_loads(workers_));
    const ConnectionLoad carried = load(*scene, 0, 1);
    EXPECT_NEAR(std::abs(carried.twist_nm), kPatch * kGravity, 0.02 * kPatch * kGravity);
}

// Without a material that resists, nothing is stored and nothing is different.
TEST_F(TurningFrictionOf, ABallWithoutItRollsOn) {
    auto scene = scene_on_plane();
    need(scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .linear_velocity_m_s = {1, 0, 0}, .angular_velocity_rad_s = {0, 2, 0}}));
    run(*scene, 2400, 2, workers_);
    EXPECT_NEAR(scene->state(0).linear_velocity_m_s.x, 1, 1e-3);
}

TEST_F(TurningFrictionOf, ARadiusThatIsNoneIsAnError) {
    auto scene = make_scene();
    EXPECT_FALSE(scene->add_material({.rolling_m = -1}));
    EXPECT_FALSE(scene->add_material({.spinning_m = std::numeric_limits<float>::infinity()}));
    auto other = make_scene({.engine = EngineKind::Hash});
    EXPECT_EQ(other->add_material({.rolling_m = 0.1f}).error().problem, "the engine Hash has no friction against rolling and spinning");
}

// Balls, cubes, cylinders and composites of them on a ground, all of which resist.
void furnish_turning(Scene& scene, const std::function<bool(BodyId)>& mine) {
    const auto rough = need(scene.add_material({.rolling_m = 0.03f, .spinning_m = 0.02f}));
    const auto bouncy = need(scene.add_material({.restitution = 0.4f, .rolling_m = 0.01f}));
    need(scene.add_obstacle(Plane{}, 0));
    need(scene.add_obstacle(Box{.centre = {6, 6, 1}, .size_m = {3, 2, 2}}, rough));
    std::mt19937 random(9);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2), speed(-4, 4);
    const BodyShape shapes[] = {box_shape({0.7, 0.7, 0.7}, 0.02), cylinder_shape(0.4, 0.7, 0.02)};
    for (BodyId id = 0; id < 400; ++id) {
        BodySpec spec{.id = id,
                      .position_m = {1.5 * (id % 10) + jitter(random), 1.5 * (id / 10 % 10) + jitter(random), 2.7 + 1.5 * (id / 100)},
                      .linear_velocity_m_s = {speed(random), speed(random), 0},
                      .angular_velocity_rad_s = {speed(random), speed(random), speed(random)},
                      .radius_m = 0.4,
                      .material = id % 3 == 0 ? bouncy : rough};
        if (id % 4 < 2) spec.shape = shapes[id % 4];
        if (mine(id)) need(scene.add_body(spec));
    }
}

TEST_F(TurningFrictionOf, PartsWorkersAndSnapshotsGiveTheSameBits) {
    auto whole = make_scene(settings_for_shapes());
    furnish_turning(*whole, [](BodyId) { return true; });
    Divided parts(3, [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); }, furnish_turning, settings_for_shapes());
    for (int tick = 0; tick < 60; ++tick) {
        run(*whole, 1, 2, workers_);
        parts.tick();
    }
    EXPECT_EQ(parts.digest(), whole->digest());

    const auto empty = [] {
        auto scene = make_scene(settings_for_shapes());
        furnish_turning(*scene, [](BodyId) { return false; });
        return scene;
    };
    expect_same_bits(empty, [](Scene& scene) {
        // Its materials and obstacles are there.
        auto other = make_scene(settings_for_shapes());
        furnish_turning(*other, [](BodyId) { return true; });
        for (const BodyId id : other->bodies()) {
            const BodyState state = other->state(id);
            need(scene.add_body({.id = id,
                                 .position_m = state.position_m,
                                 .orientation = state.orientation,
                                 .linear_velocity_m_s = state.linear_velocity_m_s,
                                 .angular_velocity_rad_s = state.angular_velocity_rad_s,
                                 .radius_m = 0.4,
                                 .material = static_cast<std::uint8_t>(id % 3 == 0 ? 2 : 1),
                                 .shape = other->shape(id)}));
        }
        for (BodyId id = 0; id < 40; id += 10) need(scene.connect(id, id + 1));
    });
}

}  // namespace
}  // namespace meld::physics
