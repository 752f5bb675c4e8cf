// Compounds: bodies of several solids that are held together, against mechanics and as sets of their parts.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "physics/collision/ray.h"
#include "physics/scene/scene.h"
#include "tests/unit/physics/divided_world.h"
#include "tests/unit/physics/snapshots.h"
#include "tests/unit/physics/two_engines.h"

namespace meld::physics {
namespace {

constexpr double kOneDegree = std::numbers::pi / 180, kEdge_m = 1e-3;

ShapePart part_of(const BodyShape& solid, Vec3 at, Quat turn = {}) { return {solid.core_m, solid.rounding_m, at, turn, solid.volume_m3()}; }
ShapePart brick(Vec3 edges, Vec3 at) { return part_of(box_shape(edges, kEdge_m), at); }

// Two balls of radius 0.4 on a rod along x.
BodyShape dumbbell() {
    const Quat along_x = turn_of(90 * kOneDegree, {0, 1, 0});
    return compound_of({part_of({{}, 0.4}, {-0.7, 0, 0}), part_of({{}, 0.4}, {0.7, 0, 0}), part_of(capsule_shape(0.15, 1.4), {}, along_x)})
        .shape;
}
// A post of 1 x 1 x 3 on the end of a foot of 3 x 1 x 1, which begins below it.
PlacedCompound l_shape() { return compound_of({brick({3, 1, 1}, {1, 0, 0}), brick({1, 1, 2}, {0, 0, 1.5})}); }
// A C in the plane of x and z, open towards x, with lips at the ends of its arms that leave a gap; and where its back is from its centre.
struct Hook {
    BodyShape shape;
    double back;
};
Hook hook() {
    const auto [shape, centre] =
        compound_of({brick({0.2, 0.4, 1.2}, {}), brick({0.8, 0.4, 0.2}, {0.5, 0, 0.5}), brick({0.8, 0.4, 0.2}, {0.5, 0, -0.5}),
                     brick({0.2, 0.4, 0.3}, {0.8, 0, 0.25}), brick({0.2, 0.4, 0.3}, {0.8, 0, -0.25})});
    return {shape, -centre.x};
}

TEST(Compounds, HaveTheCentreAndInertiaOfTheirParts) {
    // Balls of 3 kg and 1 kg, 2 m apart.
    const auto [two, centre] = compound_of({{{}, 0.5, {0, 0, 1}, {}, 3}, {{}, 0.5, {0, 0, 3}, {}, 1}});
    EXPECT_EQ(centre, (Vec3{0, 0, 1.5}));
    EXPECT_EQ(two.parts[0].at_m, (Vec3{0, 0, -0.5}));
    EXPECT_EQ(two.parts[0].share, 0.75);
    EXPECT_NEAR(two.inertia_per_kg_m2().z, 0.4 * 0.25, 1e-12);
    EXPECT_NEAR(two.inertia_per_kg_m2().x, 0.4 * 0.25 + 0.75 * 0.25 + 0.25 * 2.25, 1e-12);
    EXPECT_NEAR(two.radius_m(), 2, 1e-12);
    EXPECT_NEAR(two.least_m(), 0.5, 1e-12);
    EXPECT_NEAR(two.volume_m3(), 2 * 4 * std::numbers::pi / 3 * 0.125, 1e-12);
    // Eight cubes make a cube; its parts are where its corners are.
    std::vector<ShapePart> eighths;
    for (int i = 0; i < 8; ++i) eighths.push_back(brick({1, 1, 1}, {1.0 * (i % 2), 1.0 * (i / 2 % 2), 1.0 * (i / 4)}));
    const BodyShape whole = compound_of(eighths).shape;
    const Vec3 eighth = box_shape({1, 1, 1}, kEdge_m).inertia_per_kg_m2();
    EXPECT_NEAR(whole.inertia_per_kg_m2().x, eighth.x + 0.5, 1e-12);
    EXPECT_EQ(whole.inertia().axes, Quat{});
    EXPECT_NEAR(whole.radius_m(), std::sqrt(3.0), 2 * kEdge_m);
    EXPECT_NEAR(whole.way_out_m({0.8, 0.36, 0.48}), 1 / 0.8, 1e-9);
    need(check(whole));
    // The principal axes of an L lie across it; their moments are those of its tensor, whose trace and determinant they keep.
    const BodyShape l = l_shape().shape;
    const BodyShape::Inertia inertia = l.inertia();
    Symmetric tensor;
    for (const ShapePart& part : l.parts) {
        const Vec3 own = part.share * solid_of(part).inertia_per_kg_m2();
        tensor += inertia_about(part.share, Symmetric{own.x, 0, 0, own.y, 0, own.z}, part.at_m);
    }
    const Vec3 m = inertia.per_kg_m2;
    const Symmetric back = turned({m.x, 0, 0, m.y, 0, m.z}, inertia.axes);
    for (const auto& [one, other] :
         {std::pair(back.xx, tensor.xx), {back.yy, tensor.yy}, {back.zz, tensor.zz}, {back.xz, tensor.xz}, {back.xy, 0}})
        EXPECT_NEAR(one, other, 1e-12);
    EXPECT_GT(std::abs(tensor.xz), 0.1);
}

TEST(Compounds, SwingAsMechanicsSays) {
    // A dumbbell with a heavy and a light ball on a hinge at its light end: a physical pendulum.
    const auto [shape, centre] = compound_of({{{}, 0.3, {0, 0, 0}, {}, 4}, {{}, 0.2, {0, 0, 1.5}, {}, 1}});
    auto scene = make_scene(settings_with({0, 0, -kGravity}, 0));
    need(scene->add_body({.id = 0, .position_m = {0, 0, 5}, .fixed = true}));
    const double arm = 2 - centre.z, angle = 0.05;
    const Vec3 from_hinge = arm * Vec3{-std::sin(angle), 0, -std::cos(angle)};
    need(scene->add_body({.id = 1, .position_m = Vec3{0, 0, 3} + from_hinge, .orientation = turn_of(angle, {0, 1, 0}), .shape = shape}));
    need(scene->add_joint({.first = 0, .second = 1, .anchor_m = {0, 0, 3}, .axis = {0, 1, 0}}));
    const double period = 2 * std::numbers::pi * std::sqrt((shape.inertia_per_kg_m2().y + arm * arm) / (kGravity * arm));
    Workers workers(1);
    double before = angle, time = 0, first = 0, last = 0;
    int crossings = 0;
    for (int tick = 0; tick < 4800; ++tick, time += kTick / 2) {
        need(scene->step(kTick / 2, 2, workers));
        const double now = scene->joint(0, 1)->place;
        if (before < 0 && now >= 0) (crossings++ == 0 ? first : last) = time + kTick / 2 * -now / (now - before);
        before = now;
    }
    ASSERT_GE(crossings, 2);
    EXPECT_NEAR((last - first) / (crossings - 1), period, 2e-3 * period);
}

TEST(Compounds, KeepTheirAngularMomentumAndEnergyAsTheyTumble) {
    auto scene = make_scene(settings_with({}, 0));
    need(scene->add_body({.id = 0, .mass_kg = 2, .shape = l_shape().shape}));
    BodyState state = scene->state(0);
    state.angular_velocity_rad_s = {1, 2, 0.5};
    need(scene->set_state(0, state));
    const Vec3 momentum = scene->angular_momentum();
    const double energy = scene->kinetic_energy_j();
    // Its tensor is that of the parts, not along its own axes.
    const BodyShape l = l_shape().shape;
    Vec3 expected;
    for (const ShapePart& part : l.parts) {
        const Vec3 w = state.angular_velocity_rad_s, own = solid_of(part).inertia_per_kg_m2();
        expected = expected + 2 * part.share * (Vec3{own.x * w.x, own.y * w.y, own.z * w.z} + cross(part.at_m, cross(w, part.at_m)));
    }
    EXPECT_LT(length(momentum - expected), 1e-5 * length(expected));
    Workers workers(1);
    run(*scene, 2400, 2, workers);
    EXPECT_LT(length(scene->angular_momentum() - momentum), 2e-3 * length(momentum));
    EXPECT_NEAR(scene->kinetic_energy_j(), energy, 5e-3 * energy);
    EXPECT_GT(length(scene->state(0).angular_velocity_rad_s - state.angular_velocity_rad_s), 0.2);
}

TEST(Compounds, OfOnePartMoveAsThatPart) {
    const auto fallen = [](bool as_compound) {
        auto scene = scene_on_plane(settings_with({0, 0, -kGravity}, 0));
        const BodyShape box = box_shape({1, 0.7, 0.4}, 0.02);
        for (BodyId id = 0; id < 4; ++id)
            need(scene->add_body({.id = id,
                                  .position_m = {0.2 * id, 0.1 * id, 0.8 + 1.2 * id},
                                  .angular_velocity_rad_s = {1, 0.5, 0.2 * id},
                                  .shape = as_compound ? compound_of({part_of(box, {})}).shape : box}));
        Workers workers(1);
        run(*scene, 60, 2, workers);
        std::vector<BodyState> states;
        for (BodyId id = 0; id < 4; ++id) states.push_back(scene->state(id));
        return states;
    };
    const auto ones = fallen(true), others = fallen(false);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_LT(length(ones[i].position_m - others[i].position_m), 1e-4) << i;
}

TEST(Compounds, AnLTipsAtItsAngle) {
    // Towards its post: the line from the edge of its foot to its centre of mass leans by this angle.
    const auto [shape, centre] = l_shape();
    const double tips = std::atan((centre.x + 0.5) / (centre.z + 0.5)) / kOneDegree;
    for (const double degrees : {tips - 0.4, tips + 0.4}) {
        const double angle = degrees * kOneDegree;
        auto scene = make_scene(settings_with(kGravity * Vec3{-std::sin(angle), 0, -std::cos(angle)}, 0));
        const auto rough = need(scene->add_material({.friction = 3}));
        need(scene->add_obstacle(Plane{}, rough));
        need(scene->add_body({.id = 0, .position_m = centre + Vec3{0, 0, 0.5}, .material = rough, .shape = shape}));
        Workers workers(1);
        run(*scene, 4 * 240, 4, workers);
        const double leans = std::acos(std::min(1.0, rotate(scene->state(0).orientation, {0, 0, 1}).z)) / kOneDegree;
        if (degrees < tips)
            EXPECT_LT(leans, 0.3) << degrees << " of " << tips;
        else
            EXPECT_GT(leans, 20) << degrees << " of " << tips;
    }
}

TEST(Compounds, HooksHoldEachOther) {
    for (const EngineKind engine : {EngineKind::Blocks, EngineKind::Ode}) {
        Settings settings = settings_with({0, 0, -kGravity}, 0);
        settings.engine = engine;
        auto scene = make_scene(settings);
        const auto [shape, back] = hook();
        need(scene->add_body({.id = 0, .fixed = true, .shape = shape}));
        // The other one stands across: its upper arm lies on the lower arm of the first, and its lip holds it as it swings away.
        need(scene->add_body({.id = 1,
                              .position_m = {back + 0.4, -0.4 - back, -0.8},
                              .orientation = turn_of(90 * kOneDegree, {0, 0, 1}),
                              .linear_velocity_m_s = {0.5, 0.7, 0},
                              .mass_kg = 2,
                              .shape = shape}));
        Workers workers(1);
        run(*scene, 960, 2, workers);
        EXPECT_NEAR(scene->state(1).position_m.z, -0.8, 0.05) << static_cast<int>(engine);
        EXPECT_LT(length(scene->state(1).linear_velocity_m_s), 0.05);
        double force = 0;
        for (const ContactReport& contact : scene->contacts()) force += contact.normal_force_n * -contact.normal.z;
        EXPECT_NEAR(std::abs(force), 2 * kGravity, 0.5);
    }
}

TEST(Compounds, LandFlatAndLeaveFlat) {
    Settings settings = settings_with({0, 0, -kGravity}, 0);
    auto scene = make_scene(settings);
    const auto bouncy = need(scene->add_material({.friction = 0.5f, .restitution = 0.8f}));
    need(scene->add_obstacle(Plane{}, bouncy));
    // A table on two thin walls, at different distances from its centre.
    const BodyShape table =
        compound_of({brick({2, 1, 0.2}, {0, 0, 0}), brick({0.2, 1, 0.6}, {-0.9, 0, -0.4}), brick({0.2, 1, 0.6}, {0.4, 0, -0.4})}).shape;
    need(scene->add_body({.id = 0, .position_m = {0, 0, 2}, .material = bouncy, .shape = table}));
    Workers workers(1);
    double fastest = 0;
    for (int tick = 0; tick < 300; ++tick) {
        run(*scene, 1, 2, workers);
        fastest = std::max(fastest, scene->state(0).linear_velocity_m_s.z);
        EXPECT_LT(length(scene->state(0).angular_velocity_rad_s), 0.05) << tick;
    }
    EXPECT_GT(fastest, 0.7 * std::sqrt(2 * kGravity * 1.2));
}

TEST(Compounds, TouchOnceHoweverManyPartsTouch) {
    auto scene = scene_on_plane(settings_with({0, 0, -kGravity}, 0));
    need(scene->add_body({.id = 3, .position_m = {0, 0, 0.405}, .shape = dumbbell()}));
    need(scene->add_body({.id = 1, .position_m = {0, 0, 1.205}, .shape = dumbbell()}));
    Workers workers(1);
    std::map<Touch, int> events;
    for (int tick = 0; tick < 60; ++tick) {
        run(*scene, 1, 2, workers);
        for (const TouchEvent& event : scene->events()) events[event.touch] += event.began ? 1 : -1;
    }
    ASSERT_EQ(events.size(), 2u);
    for (const auto& [touch, count] : events) EXPECT_EQ(count, 1);
    EXPECT_NEAR(scene->state(1).position_m.z, 1.2, 5e-3);
    double force = 0;
    for (const ContactReport& contact : scene->contacts())
        if (contact.touch.other_is_obstacle) force += contact.normal_force_n;
    EXPECT_NEAR(force, 2 * kGravity, 0.5);
    // One is lifted off.
    BodyState state = scene->state(1);
    state.position_m.z = 3;
    need(scene->set_state(1, state));
    run(*scene, 2, 2, workers);
    for (const ContactReport& contact : scene->contacts()) EXPECT_TRUE(contact.touch.other_is_obstacle);
    // A body that goes ends its touch once.
    need(scene->remove_body(3));
    run(*scene, 1, 2, workers);
    EXPECT_TRUE(scene->contacts().empty());
}

TEST(Compounds, LieOnTerrainAndMeshesAsOnAPlane) {
    const auto at_rest = [](auto ground) {
        auto scene = make_scene(settings_with({0, 0, -kGravity}, 0));
        need(scene->add_obstacle(std::move(ground), 0));
        const auto [shape, centre] = l_shape();
        need(scene->add_body({.id = 0, .position_m = centre + Vec3{0.3, 0.2, 0.55}, .linear_velocity_m_s = {2, 0.5, 0}, .shape = shape}));
        need(scene->add_body({.id = 1, .position_m = {-3, 0.1, 0.5}, .linear_velocity_m_s = {1, 0, 0}, .shape = dumbbell()}));
        Workers workers(1);
        run(*scene, 240, 2, workers);
        return std::pair(scene->state(0), scene->state(1));
    };
    Terrain terrain;
    terrain.origin = {-20, -20, 0}, terrain.cell_m = 1.3, terrain.columns = terrain.rows = 32;
    terrain.heights_m.assign(32 * 32, 0);
    const auto plane = at_rest(Plane{}), hills = at_rest(terrain);
    EXPECT_LT(length(plane.first.position_m - hills.first.position_m), 0.02);
    EXPECT_LT(length(plane.second.position_m - hills.second.position_m), 0.05);
    EXPECT_NEAR(hills.second.position_m.z, 0.4, 0.01);
}

TEST(Compounds, AreMetByRaysAndByEachOtherAsTheirPartsAre) {
    const BodyShape c = hook().shape;
    const Vec3 back = c.parts[0].at_m;
    // Into its mouth, to the back; and past its lower arm.
    const auto inside = first_on(c, {}, {}, {{5, 0, 0}, {-10, 0, 0}});
    ASSERT_TRUE(inside);
    EXPECT_NEAR(5 - 10 * *inside, back.x + 0.1, 1e-6);
    EXPECT_FALSE(first_on(c, {}, {}, {{back.x + 0.4, -5, 0}, {0, 10, 0}}));
    const auto above = first_on(c, {}, turn_of(90 * kOneDegree, {1, 0, 0}), {{back.x + 0.5, -5, 0}, {0, 10, 0}});
    ASSERT_TRUE(above);
    EXPECT_NEAR(-5 + 10 * *above, -0.6, 1e-6);
    // A ball in its mouth touches nothing.
    const BodyShape ball{{}, 0.2};
    const Attitude here{{}, {}};
    EXPECT_FALSE(nearer(c, here, ball, {{back.x + 0.4, 0, 0}, {}}, 0.05));
    EXPECT_TRUE(nearer(c, here, ball, {{back.x + 0.4, 0, 0.19}, {}}, 0.05));
}

TEST(Compounds, HaveMagnetsThatPullOnce) {
    const auto pulled = [](const BodyShape& shape) {
        auto scene = make_scene(settings_with({}, 0));
        const auto table = need(scene->add_feature_table(
            {{.direction = {1, 0, 0}, .kind = FeatureKind::Dipole, .strength = 50, .depth_m = 0.05, .range_m = 1},
             {.direction = {-1, 0, 0}, .kind = FeatureKind::Dipole, .strength = 50, .depth_m = 0.05, .range_m = 1}}));
        for (BodyId id = 0; id < 2; ++id) {
            need(scene->add_body({.id = id, .position_m = {1.3 * id, 0, 0}, .shape = shape}));
            need(scene->set_feature_table(id, table));
            need(scene->set_features(id, 3, 0));
        }
        Workers workers(1);
        run(*scene, 1, 2, workers);
        return scene->state(1).linear_velocity_m_s.x;
    };
    const BodyShape box = box_shape({1, 0.5, 0.5}, kEdge_m);
    const double whole = pulled(box), halves = pulled(compound_of({brick({0.5, 0.5, 0.5}, {}), brick({0.5, 0.5, 0.5}, {0.5, 0, 0})}).shape);
    EXPECT_GT(std::abs(whole), 1e-4);
    EXPECT_NEAR(halves, whole, 1e-3 * std::abs(whole));
    auto scene = make_scene();
    need(scene->add_body({.id = 0, .shape = compound_of({{{}, 0.2, {0, 0, 0}, {}, 1}, {{}, 0.2, {2, 0, 0}, {}, 1}}).shape}));
    const auto table = need(scene->add_feature_table({{.direction = {0, 0, 1}, .kind = FeatureKind::Dipole}}));
    const auto refused = scene->set_feature_table(0, table);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().problem.find("has no part"), std::string::npos) << refused.error().message();
}

TEST(Compounds, AreRefusedIfTheyCannotBe) {
    const auto problem = [](BodyShape shape) {
        const auto fine = check(shape);
        return fine ? std::string("fine") : fine.error().problem;
    };
    BodyShape shape = dumbbell();
    EXPECT_EQ(problem(shape), "fine");
    shape.parts[0].at_m.x -= 0.1;
    EXPECT_NE(problem(shape).find("do not balance"), std::string::npos);
    shape = dumbbell();
    shape.parts[1].rounding_m = -1;
    EXPECT_NE(problem(shape).find("no solid"), std::string::npos);
    shape = dumbbell();
    shape.parts[1].turn = {2, 0, 0, 0};
    EXPECT_NE(problem(shape).find("no rotation"), std::string::npos);
    shape = dumbbell();
    shape.rounding_m = 1;
    EXPECT_NE(problem(shape).find("core of its own"), std::string::npos);
    EXPECT_NE(problem(compound_of(std::vector<ShapePart>(65, {{}, 0.5, {}, {}, 1})).shape).find("65 parts"), std::string::npos);
    auto hash = make_scene({.engine = EngineKind::Hash});
    EXPECT_FALSE(hash->add_body({.id = 0, .shape = dumbbell()}));
}

TEST(CompoundsAgainstOde, FallTipAndRollAlike) {
    BothEngines both(1e-3);
    both.each([](Scene& scene) {
        need(scene.add_obstacle(Plane{}, 0));
        const auto [shape, centre] = l_shape();
        need(scene.add_body({.id = 0,
                             .position_m = centre + Vec3{0, 0, 0.5},
                             .orientation = turn_of(-25 * kOneDegree, {0, 1, 0}),
                             .mass_kg = 2,
                             .shape = shape}));
        BodyState state = scene.state(0);
        state.position_m.z += 1;
        need(scene.set_state(0, state));
        need(scene.add_body({.id = 1, .position_m = {0, 5, 0.4}, .linear_velocity_m_s = {0, 2, 0}, .shape = dumbbell()}));
    });
    EXPECT_LT(both.most_apart(0.5), 0.03);
    EXPECT_LT(both.turned(0), 0.05);
    both.go(1.5);
    both.each([](Scene& scene) {
        const BodyState state = scene.state(1);
        EXPECT_NEAR(state.position_m.z, 0.4, 5e-3);
        EXPECT_NEAR(state.linear_velocity_m_s.y, 0.4 * -state.angular_velocity_rad_s.x, 0.02);
    });
    EXPECT_LT(both.apart(1), 0.05);
}

TEST(Compounds, KeepMomentumInACrowd) {
    auto scene = make_scene(settings_with({}, 0));
    const BodyShape shapes[] = {compound_of({brick({0.9, 0.3, 0.3}, {0.3, 0, 0}), brick({0.3, 0.3, 0.9}, {0, 0, 0.3})}).shape,
                                compound_of({{{}, 0.25, {-0.4, 0, 0}, {}, 1}, {{}, 0.25, {0.4, 0, 0}, {}, 2}}).shape,
                                box_shape({0.6, 0.6, 0.6}, 0.02)};
    add_implosion(*scene, 3, [&](BodySpec& spec) {
        spec.radius_m = 0.4;
        if (spec.id % 4 < 3) spec.shape = shapes[spec.id % 4];
    });
    expect_kept_momentum(*scene);
}

// Compounds of all kinds, with boxes and balls among them, fall onto a plane, a box and each other; some bounce and some are connected.
constexpr std::uint8_t kBouncyGround = 1;
std::unique_ptr<Scene> ground_for_compounds(Scene* there = nullptr) {
    auto scene = there == nullptr ? make_scene(settings_for_shapes()) : nullptr;
    Scene& it = there == nullptr ? *scene : *there;
    EXPECT_EQ(need(it.add_material({.friction = 0.4f, .restitution = 0.3f})), kBouncyGround);
    need(it.add_obstacle(Plane{}, kBouncyGround));
    need(it.add_obstacle(Box{.centre = {6, 6, 1}, .size_m = {3, 2, 2}}, 0));
    return scene;
}

void add_compounds(Scene& scene, const std::function<bool(BodyId)>& mine) {
    const BodyShape shapes[] = {
        compound_of({brick({0.9, 0.4, 0.4}, {0.25, 0, 0}), brick({0.4, 0.4, 0.9}, {0, 0, 0.25})}).shape,
        compound_of({{{}, 0.3, {-0.4, 0, 0}, {}, 1}, {{}, 0.3, {0.4, 0, 0}, {}, 2}}).shape, box_shape({0.6, 0.6, 0.6}, 0.02),
        compound_of({part_of(cylinder_shape(0.5, 0.4, 0.02), {0, 0, 0.2}), part_of(capsule_shape(0.2, 1), {0, 0, -0.3})}).shape};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2), speed(-4, 4);
    for (BodyId id = 0; id < 125; ++id) {
        BodySpec spec{.id = id,
                      .position_m = {1.9 * (id % 5) + jitter(random), 1.9 * (id / 5 % 5) + jitter(random), 3 + 1.9 * (id / 25)},
                      .linear_velocity_m_s = {speed(random), speed(random), speed(random)},
                      .angular_velocity_rad_s = {speed(random), speed(random), speed(random)},
                      .radius_m = 0.4,
                      .material = static_cast<std::uint8_t>(id % 3 == 0 ? kBouncyGround : 0)};
        if (id % 5 < 4) spec.shape = shapes[id % 5];
        if (mine(id)) need(scene.add_body(spec));
    }
}

void furnish_compounds(Scene& scene, const std::function<bool(BodyId)>& mine) {
    ground_for_compounds(&scene);
    add_compounds(scene, mine);
}

TEST(Compounds, MoveAlikeWithAnyNumberOfThreadsAndFromSnapshots) {
    expect_same_bits([] { return ground_for_compounds(); }, [](Scene& scene) { add_compounds(scene, [](BodyId) { return true; }); });
}

TEST(Compounds, MoveAlikeInADividedWorld) {
    auto whole = make_scene(settings_for_shapes());
    furnish_compounds(*whole, [](BodyId) { return true; });
    Workers workers(1);
    run(*whole, 150, 2, workers);
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    Divided divided(3, scattered, furnish_compounds, settings_for_shapes());
    for (int tick = 0; tick < 150; ++tick) divided.tick();
    EXPECT_EQ(divided.digest(), whole->digest());
    EXPECT_GT(divided.rebuilds, 10);
}

}  // namespace
}  // namespace meld::physics
