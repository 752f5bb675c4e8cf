// Latches on boxes, cylinders, capsules, compounds and balls beside them: with how much force they hold, where, and with the same bits
// everywhere.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "physics/scene/scene.h"
#include "tests/unit/physics/divided_world.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics::shape_latches {
namespace {

constexpr double kStrength = 40, kReach_m = 0.03;

// A body whose latch is at `way_m` from its middle.
struct Kind {
    std::string name;
    std::optional<BodyShape> shape;
    Vec3 direction;
    double way_m;
};

BodyShape made_of(std::vector<ShapePart> parts) { return compound_of(std::move(parts)).shape; }
ShapePart part(const BodyShape& shape, Vec3 at, Quat turn = {}) { return {shape.core_m, shape.rounding_m, at, turn, 1}; }

// Cubes, of which the latch is on the common plane of two halves, or the common line of four quarters; a slab on a ball; and a rod with a
// ball at each end.
const BodyShape kHalves = made_of({part(box_shape({0.5, 1, 1}, 0), {-0.25, 0, 0}), part(box_shape({0.5, 1, 1}, 0), {0.25, 0, 0})});
const BodyShape kQuarters =
    made_of({part(box_shape({1, 0.5, 0.5}, 0), {0, -0.25, -0.25}), part(box_shape({1, 0.5, 0.5}, 0), {0, -0.25, 0.25}),
             part(box_shape({1, 0.5, 0.5}, 0), {0, 0.25, -0.25}), part(box_shape({1, 0.5, 0.5}, 0), {0, 0.25, 0.25})});
const BodyShape kMushroom = made_of({part(box_shape({1, 0.8, 0.4}, 0.02), {}), part({{}, 0.3}, {0, 0, 0.4})});
const BodyShape kBarbell = made_of({part({{}, 0.3}, {-0.7, 0, 0}), part({{}, 0.3}, {0.7, 0, 0}),
                                    part(capsule_shape(0.1, 1.4), {}, turn_of(std::numbers::pi / 2, {0, 1, 0}))});

const std::vector<Kind> kKinds = {{"cube", box_shape({1, 1, 1}, 0.02), {1, 0, 0}, 0.5},
                                  {"sharp brick", box_shape({0.6, 1, 0.8}, 0), {0, 0, -1}, 0.4},
                                  {"cylinder's cap", cylinder_shape(0.4, 0.6, 0.02), {0, 0, 1}, 0.3},
                                  {"cylinder's rim", cylinder_shape(0.4, 0.6, 0.02), {0, 1, 0}, 0.4},
                                  {"capsule's side", capsule_shape(0.25, 1.2), {0, -1, 0}, 0.25},
                                  {"capsule's end", capsule_shape(0.25, 1.2), {0, 0, 1}, 0.6},
                                  {"ball", std::nullopt, {0, 1, 0}, 0.5},
                                  {"halves", kHalves, {0, 0, 1}, kHalves.way_out_m({0, 0, 1})},
                                  {"quarters", kQuarters, {1, 0, 0}, kQuarters.way_out_m({1, 0, 0})},
                                  {"mushroom's foot", kMushroom, {0, 0, -1}, kMushroom.way_out_m({0, 0, -1})},
                                  {"mushroom's head", kMushroom, {0, 0, 1}, kMushroom.way_out_m({0, 0, 1})},
                                  {"barbell's end", kBarbell, {1, 0, 0}, kBarbell.way_out_m({1, 0, 0})}};

// The rotation that brings one direction to another.
Quat turn_from(Vec3 one, Vec3 other) {
    const Vec3 axis = cross(one, other);
    if (length(axis) < 1e-9)
        return dot(one, other) > 0 ? Quat{} : turn_of(std::numbers::pi, std::abs(one.x) > 0.5 ? Vec3{0, 1, 0} : Vec3{1, 0, 0});
    return turn_of(std::atan2(length(axis), dot(one, other)), axis);
}

class ShapeLatches : public testing::TestWithParam<EngineKind> {
  protected:
    static std::unique_ptr<Scene> scene_with(Settings settings = {.gravity_m_s2 = {}, .sleep_ticks = 0}) {
        settings.engine = GetParam();
        if (GetParam() != EngineKind::Blocks) settings.solver = SolverSettings::pgs20();
        return make_scene(settings);
    }
    // Body 0 is fixed with its latch at the origin, and body 1 is held there, in the direction x.
    static void add_two(Scene& scene, const Kind& one, const Kind& other, double strength = kStrength) {
        const auto add = [&](BodyId id, const Kind& kind, Vec3 facing) {
            const auto table = need(scene.add_feature_table(
                {{.direction = kind.direction, .kind = FeatureKind::Latch, .strength = strength, .range_m = kReach_m}}));
            need(scene.add_body({.id = id,
                                 .position_m = -kind.way_m * facing,
                                 .orientation = turn_from(kind.direction, facing),
                                 .fixed = id == 0,
                                 .shape = kind.shape}));
            need(scene.set_feature_table(id, table));
            need(scene.set_features(id, 1, 0));
        };
        add(0, one, {1, 0, 0});
        add(1, other, {-1, 0, 0});
    }
    // Whether body 1 is still there after it was pulled for a second.
    bool holds(Scene& scene, Vec3 force_n, Vec3 torque_nm) {
        const Vec3 before = scene.state(1).position_m;
        need(scene.set_wrench(1, force_n, torque_nm));
        run(scene, 240, 2, workers_);
        return length(scene.state(1).position_m - before) < kReach_m;
    }
    Workers workers_{1};
};

TEST_P(ShapeLatches, HoldUpToTheirForce) {
    for (const Kind& one : kKinds)
        for (const Kind& other : kKinds) {
            if (!one.shape && !other.shape) continue;
            for (const double share : {0.99, 1.01}) {
                auto scene = scene_with();
                add_two(*scene, one, other);
                EXPECT_EQ(holds(*scene, {share * kStrength, 0, 0}, {}), share < 1) << one.name << ", " << other.name << ", " << share;
                if (share > 1) continue;
                const auto contacts = scene->contacts();
                double force_n = 0;
                for (const ContactReport& contact : contacts) force_n += contact.normal_force_n;
                EXPECT_NEAR(force_n, -share * kStrength, 0.02 * kStrength) << one.name << ", " << other.name;
            }
        }
}

// A face that is pulled open about its edge: the force has half of the edge's length as its arm. A latch beside the middle has less on one
// side and more on the other. It is the same for cubes of one piece and of quarters.
TEST_P(ShapeLatches, HoldWhereTheyAre) {
    const BodyShape cube = box_shape({1, 1, 1}, 0);
    for (const auto& [fixed, held] : {std::pair(cube, cube), std::pair(cube, kQuarters), std::pair(kQuarters, kQuarters)})
        for (const double beside : {0.0, 0.3})
            for (const auto& [side, share] : {std::pair(-1.0, 0.98), std::pair(-1.0, 1.02), std::pair(1.0, 0.98), std::pair(1.0, 1.02)}) {
                auto scene = scene_with();
                for (const BodyId id : {0u, 1u}) {
                    const auto table = need(scene->add_feature_table({{.direction = {id == 0 ? 0.5 : -0.5, beside, 0},
                                                                       .kind = FeatureKind::Latch,
                                                                       .strength = kStrength,
                                                                       .range_m = kReach_m}}));
                    need(scene->add_body(
                        {.id = id, .position_m = {id == 0 ? 0.0 : 1.0, 0, 0}, .fixed = id == 0, .shape = id == 0 ? fixed : held}));
                    need(scene->set_feature_table(id, table));
                    need(scene->set_features(id, 1, 0));
                }
                // About the edge at y = side / 2, at whose other side it opens.
                const double most = kStrength * (0.5 - side * beside);
                EXPECT_EQ(holds(*scene, {}, {0, 0, side * share * most}), share < 1)
                    << fixed.solids() << ", " << held.solids() << ", " << beside << ", " << side << ", " << share;
            }
}

// What holds presses, so what is pulled along slips only beyond the friction of the latch's force.
TEST_P(ShapeLatches, HoldByFriction) {
    const Kind quarters{"quarters", kQuarters, {1, 0, 0}, 0.5};
    for (const Kind& kind : {kKinds[0], quarters})
        for (const double share : {0.95, 1.05}) {
            auto scene = scene_with();
            add_two(*scene, kind, kind);
            EXPECT_EQ(holds(*scene, {0, 0, share * 0.5 * kStrength}, {}), share < 1) << kind.name << ", " << share;
        }
}

TEST_P(ShapeLatches, CarryAChainAndLetGo) {
    const int links = 5;
    const double weight = links * kGravity;
    for (const double strength : {1.1 * weight, 0.95 * weight}) {
        auto scene = scene_with({.sleep_ticks = 0});
        const auto table =
            need(scene->add_feature_table({{.direction = {0, 0, 1}, .kind = FeatureKind::Latch, .strength = strength, .range_m = 0.05},
                                           {.direction = {0, 0, -1}, .kind = FeatureKind::Latch, .strength = strength, .range_m = 0.05}}));
        for (BodyId id = 0; id <= links; ++id) {
            BodySpec spec{.id = id, .position_m = {0, 0, -1.0 * id}, .fixed = id == 0};
            if (id % 3 != 2) spec.shape = id % 3 == 0 ? box_shape({1, 0.8, 1}, 0.02) : cylinder_shape(0.4, 1, 0.01);
            need(scene->add_body(spec));
            need(scene->set_feature_table(id, table));
            need(scene->set_features(id, 3, 0));
        }
        run(*scene, 480, 2, workers_);
        const bool holds = strength > weight;
        EXPECT_EQ(std::abs(scene->state(links).position_m.z + links) < 0.02, holds) << strength / weight;
        if (!holds) continue;
        need(scene->set_features(3, 0, 0));
        run(*scene, 120, 2, workers_);
        EXPECT_NEAR(scene->state(2).position_m.z, -2, 0.02);
        EXPECT_LT(scene->state(3).position_m.z, -4);
        EXPECT_LT(scene->state(4).position_m.z, -5);
    }
}

// Two that are apart by less than the range come together, slowly.
TEST(ShapeLatch, ClosesAGap) {
    auto scene = make_scene({.gravity_m_s2 = {}, .sleep_ticks = 0});
    Workers workers(1);
    const auto table =
        need(scene->add_feature_table({{.direction = {1, 0, 0}, .kind = FeatureKind::Latch, .strength = 1e4, .range_m = 0.1},
                                       {.direction = {-1, 0, 0}, .kind = FeatureKind::Latch, .strength = 1e4, .range_m = 0.1}}));
    for (const BodyId id : {0u, 1u}) {
        need(scene->add_body({.id = id, .position_m = {1.08 * id, 0, 0}, .shape = box_shape({1, 1, 1}, 0.02)}));
        need(scene->set_feature_table(id, table));
        need(scene->set_features(id, 3, 0));
    }
    double fastest = 0;
    for (int tick = 0; tick < 240; ++tick) {
        run(*scene, 1, 2, workers);
        fastest = std::max(fastest, length(scene->state(1).linear_velocity_m_s));
    }
    EXPECT_NEAR(scene->state(1).position_m.x - scene->state(0).position_m.x, 1, 2e-3);
    EXPECT_LT(fastest, 0.5);
    EXPECT_LT(length(scene->momentum()), 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Engines, ShapeLatches, testing::Values(EngineKind::Blocks, EngineKind::Ode),
                         [](const auto& engine) { return engine.param == EngineKind::Blocks ? "Blocks" : "Ode"; });

// Clumps of all shapes that latches hold fall on a plane and on each other, and some break.
std::uint16_t add_plane_and_table(Scene& scene) {
    need(scene.add_obstacle(Plane{}, 0));
    std::vector<Feature> features;
    for (const Vec3 direction : feature_directions(6))
        features.push_back({.direction = direction, .kind = FeatureKind::Latch, .strength = 60, .range_m = 0.08});
    features.push_back({.direction = {0, 0, 1}, .strength = 100, .depth_m = 0.05, .range_m = 0.2});
    return need(scene.add_feature_table(features));
}

void add_clumps(Scene& scene, std::uint16_t table, const std::function<bool(BodyId)>& mine) {
    const BodyShape halves = made_of({part(box_shape({0.4, 0.8, 0.8}, 0), {-0.2, 0, 0}), part(box_shape({0.4, 0.8, 0.8}, 0), {0.2, 0, 0})});
    const BodyShape shapes[] = {box_shape({0.8, 0.8, 0.8}, 0.02), cylinder_shape(0.4, 0.8, 0.02), capsule_shape(0.3, 0.8), halves};
    for (BodyId id = 0; id < 240; ++id) {
        if (!mine(id)) continue;
        const BodyId clump = id / 12, part = id % 12;
        BodySpec spec{.id = id,
                      .position_m = {2.6 * (clump % 5) + 0.81 * (part % 3), 2.2 * (clump / 5) + 0.81 * (part / 3 % 2),
                                     1.2 + 0.5 * (clump % 3) + 0.81 * (part / 6)},
                      .linear_velocity_m_s = {1.5 * (clump % 3) - 1.5, clump % 2 - 0.5, -2},
                      .radius_m = 0.4};
        if (part % 5 != 4) spec.shape = shapes[part % 5];
        need(scene.add_body(spec));
        need(scene.set_feature_table(id, table));
        need(scene.set_features(id, 0x7f, id % 2 == 0 ? 0x40 : 0));
    }
}

void furnish_clumps(Scene& scene, const std::function<bool(BodyId)>& mine) { add_clumps(scene, add_plane_and_table(scene), mine); }

TEST(ShapeLatch, SameBitsInParts) {
    const Settings settings = settings_for_shapes();
    auto whole = make_scene(settings);
    furnish_clumps(*whole, [](BodyId) { return true; });
    Workers workers(1);
    run(*whole, 150, 2, workers);
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    const auto halves = [](BlockCoordinates c) { return c.x < 1 ? 0 : 1; };
    for (const auto& [parts, owner] : {std::pair<int, Subdomain::OwnerOf>{2, halves}, {3, scattered}}) {
        Divided divided(parts, owner, furnish_clumps, settings);
        for (int tick = 0; tick < 150; ++tick) divided.tick();
        EXPECT_EQ(divided.digest(), whole->digest()) << parts;
        EXPECT_GT(divided.rebuilds, 3);
    }
}

TEST(ShapeLatch, SameBitsForAnyNumberOfWorkersAndAfterASnapshot) {
    std::uint16_t table = 0;
    const auto empty = [&] {
        auto scene = make_scene(settings_for_shapes());
        table = add_plane_and_table(*scene);
        return scene;
    };
    expect_same_bits(empty, [&](Scene& scene) { add_clumps(scene, table, [](BodyId) { return true; }); });
}

TEST(ShapeLatch, HoldsMembersOfComposites) {
    // A rod of three cubes is held at its end by a fixed cube; it turns about the edge beneath.
    for (const double share : {0.98, 1.02}) {
        auto scene = make_scene({.sleep_ticks = 0});
        Workers workers(1);
        // About the edge, three weights have an arm of one and a half edges, and the latch of half an edge.
        const double strength = 3 * kGravity * 1.5 / 0.5 / share;
        const auto table =
            need(scene->add_feature_table({{.direction = {1, 0, 0}, .kind = FeatureKind::Latch, .strength = strength, .range_m = 0.03},
                                           {.direction = {-1, 0, 0}, .kind = FeatureKind::Latch, .strength = strength, .range_m = 0.03}}));
        for (BodyId id = 0; id < 4; ++id) {
            need(scene->add_body({.id = id, .position_m = {1.0 * id, 0, 0}, .fixed = id == 0, .shape = box_shape({1, 1, 1}, 0)}));
            need(scene->set_feature_table(id, table));
            need(scene->set_features(id, id < 2 ? 3 : 0, 0));
        }
        need(scene->connect(1, 2));
        need(scene->connect(2, 3));
        run(*scene, 240, 2, workers);
        EXPECT_EQ(scene->state(3).position_m.z > -0.1, share < 1) << share;
    }
}

}  // namespace
}  // namespace meld::physics::shape_latches
