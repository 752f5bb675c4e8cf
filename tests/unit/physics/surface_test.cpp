// Boxes, cylinders and capsules on terrain and meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "physics/collision/nearest_cores.h"
#include "physics/collision/surface_contacts.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics::surfaces {
namespace {

// Of an obstacle.
using Ground = std::remove_cvref_t<decltype(std::declval<const Obstacles&>().shape(0))>;
using Found = std::array<Manifold, kMaxSurfaceContacts>;

const std::vector<std::pair<std::string, BodyShape>> kShapes = {{"a box", box_shape({1, 0.8, 0.4}, 0.02)},
                                                                {"a box with sharp edges", box_shape({1, 0.8, 0.4}, 0)},
                                                                {"a cylinder", cylinder_shape(0.5, 0.6, 0.02)},
                                                                {"a cylinder with a sharp rim", cylinder_shape(0.4, 1.2, 0)},
                                                                {"a capsule", capsule_shape(0.25, 1.4)}};

Core core_of(const BodyShape& shape) { return {shape.core_m, shape.rounding_m}; }

// A grid of triangles from (-side, -side) to (side, side), its inner points moved about, and its heights as given.
Mesh grid_mesh(int cells, double side, unsigned seed, const std::function<double(double, double)>& height) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> shift(-0.3, 0.3);
    Mesh mesh;
    const double cell = 2 * side / cells;
    for (int y = 0; y <= cells; ++y)
        for (int x = 0; x <= cells; ++x) {
            const bool inner = x > 0 && y > 0 && x < cells && y < cells;
            const double at_x = -side + cell * (x + (inner ? shift(random) : 0)), at_y = -side + cell * (y + (inner ? shift(random) : 0));
            mesh.points.push_back({at_x, at_y, height(at_x, at_y)});
        }
    const auto corner = [&](int x, int y) { return static_cast<std::uint32_t>(y * (cells + 1) + x); };
    for (int y = 0; y < cells; ++y)
        for (int x = 0; x < cells; ++x) {
            const std::uint32_t a = corner(x, y), b = corner(x + 1, y), c = corner(x + 1, y + 1), d = corner(x, y + 1);
            // Triangles that turn either way, and are split either way.
            const std::vector<std::uint32_t> both = (x + y) % 2 == 0 ? std::vector{a, b, c, a, d, c} : std::vector{a, d, b, b, c, d};
            mesh.triangles.insert(mesh.triangles.end(), both.begin(), both.end());
        }
    return mesh;
}
Mesh flat_mesh(int cells, double side, unsigned seed = 1) {
    return grid_mesh(cells, side, seed, [](double, double) { return 0.0; });
}

Terrain terrain_of(int cells, double side, const std::function<double(double, double)>& height) {
    Terrain terrain{.origin = {-side, -side, 0}, .cell_m = 2 * side / cells, .columns = cells + 1, .rows = cells + 1};
    for (int y = 0; y <= cells; ++y)
        for (int x = 0; x <= cells; ++x) terrain.heights_m.push_back(height(-side + terrain.cell_m * x, -side + terrain.cell_m * y));
    return terrain;
}

double bumps(double x, double y) { return 0.25 * std::sin(1.7 * x) * std::cos(1.3 * y) + 0.1 * std::sin(4.1 * x + 2.3 * y); }

Quat random_turn(std::mt19937& random) {
    std::normal_distribution<double> normal;
    const Quat q{normal(random), normal(random), normal(random), normal(random)};
    const double n = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    return {q.w / n, q.x / n, q.y / n, q.z / n};
}

std::vector<Triangle> triangles_of(const Mesh& mesh) {
    std::vector<Triangle> all;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
        all.push_back({mesh.points[mesh.triangles[i]], mesh.points[mesh.triangles[i + 1]], mesh.points[mesh.triangles[i + 2]]});
    return all;
}

double least_gap(const Found& found, int count) {
    double least = HUGE_VAL;
    for (int m = 0; m < count; ++m)
        for (int p = 0; p < found[static_cast<std::size_t>(m)].count; ++p)
            least = std::min(least, found[static_cast<std::size_t>(m)].points[static_cast<std::size_t>(p)].gap_m);
    return least;
}

TEST(SurfaceContacts, AFlatSurfaceHasThePointsOfAPlane) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> gap(-0.01, 0.05), place(-1, 1), angle(-0.1, 0.1);
    Obstacles obstacles;
    ASSERT_TRUE(obstacles.add(flat_mesh(17, 4), 0));
    ASSERT_TRUE(obstacles.add(terrain_of(9, 4, [](double, double) { return 0.0; }), 0));
    for (const auto& [name, shape] : kShapes)
        for (int trial = 0; trial < 400; ++trial) {
            const Core core = core_of(shape);
            // Upright, lying, hardly leaning, or in any attitude.
            Quat turn = trial % 4 == 0 ? Quat{} : trial % 4 == 1 ? turn_of(M_PI / 2, {0, 1, 0}) : random_turn(random);
            if (trial % 4 == 2) turn = turn_of(angle(random), {place(random), place(random), 0.1});
            Pose pose = pose_of({place(random), place(random), 0}, turn);
            pose.centre.z = -around(core, pose).low.z + gap(random);
            constexpr double kReach = 0.04;
            AxisHint hint = kNoAxis, other = kNoAxis;
            Manifold plane;
            collide_with_plane(core, pose, {0, 0, 1}, 0, kReach, hint, plane);
            for (const std::size_t obstacle : {0u, 1u}) {
                Found found;
                other = kNoAxis;
                const int count = obstacles.collide_shape(obstacle, core, pose, kReach, other, found);
                ASSERT_EQ(count, plane.count > 0 ? 1 : 0) << name << " in trial " << trial << " on obstacle " << obstacle;
                if (count == 0) continue;
                ASSERT_EQ(found[0].count, plane.count) << name << " in trial " << trial << " on obstacle " << obstacle;
                ASSERT_EQ(other, hint);
                EXPECT_LT(length(found[0].normal - plane.normal), 1e-12);
                for (const ManifoldPoint& point : std::span(plane.points).first(static_cast<std::size_t>(plane.count)))
                    EXPECT_TRUE(std::ranges::any_of(std::span(found[0].points).first(static_cast<std::size_t>(found[0].count)),
                                                    [&](const ManifoldPoint& one) {
                                                        return length(one.at - point.at) < 1e-9 && std::abs(one.gap_m - point.gap_m) < 1e-9;
                                                    }))
                        << name << " in trial " << trial;
            }
        }
}

// The distance to each triangle by itself, with the core as it is.
TEST(SurfaceContacts, TheNearestPointIsThatOfTheNearestTriangle) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> place(-1.5, 1.5), height(0.2, 1.2);
    const Mesh mesh = grid_mesh(14, 4, 3, bumps);
    const std::vector<Triangle> all = triangles_of(mesh);
    Obstacles obstacles;
    ASSERT_TRUE(obstacles.add(mesh, 0));
    int compared = 0;
    for (const auto& [name, shape] : kShapes)
        for (int trial = 0; trial < 600; ++trial) {
            const Core core = core_of(shape);
            const Pose pose = pose_of({place(random), place(random), height(random)}, random_turn(random));
            constexpr double kReach = 0.1;
            const PlacedCore placed{kind_of(core), core.half_m, {}, &pose.axes};
            double nearest = HUGE_VAL;
            for (const Triangle& t : all) {
                const Vec3 middle = (1.0 / 3) * (t.a + t.b + t.c);
                const std::array<Vec3, 3> corners{t.a - middle, t.b - middle, t.c - middle};
                const PlacedCore triangle{CoreKind::Triangle, {}, middle - pose.centre, &corners};
                LineEnds ends;
                const Nearness near = nearest_of_cores(placed, triangle, HUGE_VAL, ends);
                nearest = std::min(nearest, near == Nearness::Overlapping ? -HUGE_VAL : length(ends.q - ends.p) - core.radius_m);
            }
            if (nearest < 1e-3 || nearest > 0.8 * kReach) continue;
            AxisHint hint = kNoAxis;
            Found found;
            const int count = obstacles.collide_shape(0, core, pose, kReach, hint, found);
            ASSERT_GT(count, 0) << name << " in trial " << trial << ", " << nearest;
            EXPECT_NEAR(least_gap(found, count), nearest, 0.01) << name << " in trial " << trial;
            ++compared;
        }
    EXPECT_GT(compared, 200);
}

TEST(SurfaceContacts, AValleyHoldsFromBothSidesAndARidgeOnce) {
    const Core core = core_of(box_shape({1, 1, 1}, 0.02));
    Found found;
    AxisHint hint = kNoAxis;
    const auto along_y = [&](const std::function<double(double)>& height, Vec3 centre, Quat turn) {
        Obstacles obstacles;
        EXPECT_TRUE(obstacles.add(terrain_of(8, 4, [&](double x, double) { return height(x); }), 0));
        hint = kNoAxis;
        return obstacles.collide_shape(0, core, pose_of(centre, turn), 0.01, hint, found);
    };
    // A quarter of a turn between the slopes, in which the box stands on an edge.
    const double root = std::sqrt(0.5);
    ASSERT_EQ(along_y([](double x) { return std::abs(x); }, {0, 0, 2 * root * 0.5}, turn_of(M_PI / 4, {0, 1, 0})), 2);
    for (int m : {0, 1}) {
        const Manifold& side = found[static_cast<std::size_t>(m)];
        EXPECT_EQ(side.count, 4);
        EXPECT_NEAR(std::abs(side.normal.x), root, 1e-9);
        EXPECT_NEAR(side.normal.z, -root, 1e-9);
    }
    // On a ridge it stands on a line across its face.
    ASSERT_EQ(along_y([](double x) { return -std::abs(x); }, {0.2, 0, 0.5}, {}), 1);
    EXPECT_NEAR(found[0].normal.z, -1, 1e-9);
    ASSERT_GE(found[0].count, 2);
    for (int p = 0; p < found[0].count; ++p) EXPECT_NEAR(found[0].points[static_cast<std::size_t>(p)].at.x, -0.2, 1e-6);
    // A step beside it is a wall.
    ASSERT_EQ(along_y([](double x) { return x > 0.9 ? 3.0 : 0.0; }, {-0.53, 0, 0.5}, {}), 1);
    EXPECT_NEAR(found[0].normal.z, -1, 1e-9);
}

struct Slid {
    double way, turned;
};
// How far a body gets that is pushed.
Slid slide(const Ground& ground, const BodyShape& shape, Quat turn, Vec3 start, Vec3 velocity) {
    auto scene = make_scene({.sleep_ticks = 0});
    const auto material = need(scene->add_material({.friction = 0.3f}));
    need(scene->add_obstacle(ground, material));
    const Pose pose = pose_of({}, turn);
    const double height = -around(core_of(shape), pose).low.z;
    need(scene->add_body({.id = 0,
                          .position_m = start + Vec3{0, 0, height},
                          .orientation = turn,
                          .linear_velocity_m_s = velocity,
                          .material = material,
                          .shape = shape}));
    Workers workers(1);
    run(*scene, 480, 2, workers);
    const BodyState state = scene->state(0);
    const double dot_of =
        state.orientation.w * turn.w + state.orientation.x * turn.x + state.orientation.y * turn.y + state.orientation.z * turn.z;
    return {length(state.position_m - start - Vec3{0, 0, height}), 2 * std::acos(std::min(1.0, std::abs(dot_of)))};
}

TEST(OnSurfaces, ABodySlidesOverAFlatOneAsOverAPlane) {
    const Vec3 start{-2.9, -0.4, 0};
    for (const auto& [name, shape] : kShapes) {
        const Quat turn = shape.core_m.x == 0 ? turn_of(M_PI / 2, {0, 1, 0}) : Quat{};
        for (const Vec3 velocity : {Vec3{4, 0.1, 0}, Vec3{3.6, 0.9, 0}}) {
            const Slid plane = slide(Plane{}, shape, turn, start, velocity);
            const Slid mesh = slide(flat_mesh(31, 5), shape, turn, start, velocity);
            const Slid wide = slide(flat_mesh(3, 5, 4), shape, turn, start, velocity);
            const Slid ground = slide(terrain_of(20, 5, [](double, double) { return 0.0; }), shape, turn, start, velocity);
            // A capsule that is pushed aslant rolls, too.
            if (shape.core_m.x > 0) {
                EXPECT_NEAR(plane.way, dot(velocity, velocity) / (2 * 0.3 * kGravity), 0.05 * plane.way) << name;
            }
            for (const Slid& one : {mesh, wide, ground}) {
                EXPECT_NEAR(one.way, plane.way, 0.01 * plane.way) << name;
                EXPECT_NEAR(one.turned, plane.turned, 0.02) << name;
            }
        }
    }
}

TEST(OnSurfaces, ALogRollsOverAFlatOneAsOverAPlane) {
    const auto roll = [](const Ground& ground) {
        auto scene = make_scene({.sleep_ticks = 0});
        need(scene->add_obstacle(ground, 0));
        need(scene->add_body({.id = 0,
                              .position_m = {-4, 0, 0.4},
                              .orientation = turn_of(M_PI / 2, {1, 0, 0}),
                              .linear_velocity_m_s = {3, 0, 0},
                              .shape = cylinder_shape(0.4, 1.2, 0.02)}));
        Workers workers(1);
        run(*scene, 480, 2, workers);
        return scene->state(0);
    };
    const BodyState plane = roll(Plane{}), mesh = roll(flat_mesh(37, 8));
    EXPECT_NEAR(mesh.position_m.x, plane.position_m.x, 0.01 * (plane.position_m.x + 4));
    EXPECT_NEAR(mesh.linear_velocity_m_s.x, plane.linear_velocity_m_s.x, 0.01 * plane.linear_velocity_m_s.x);
    EXPECT_NEAR(mesh.position_m.z, 0.4, 1e-3);
}

// Bumpy ground of one kind or the other, on which little slides.
std::unique_ptr<Scene> rough_ground(bool as_mesh, const Settings& settings) {
    auto scene = make_scene(settings);
    const auto rough = need(scene->add_material({.friction = 0.9f}));
    if (as_mesh)
        need(scene->add_obstacle(grid_mesh(40, 8, 7, bumps), rough));
    else
        need(scene->add_obstacle(terrain_of(40, 8, bumps), rough));
    return scene;
}
// One of the first two shapes, somewhere above it.
void drop_box(Scene& scene, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-4, 4);
    const Vec3 at{place(random), place(random), 1.4};
    need(scene.add_body({.id = 0, .position_m = at, .orientation = random_turn(random), .material = 1, .shape = kShapes[seed % 2].second}));
}
// What it has by its height, and by the motion of its middle and its turning, for each kilogram.
double energy_of_box(const BodyState& state, const BodyShape& shape) {
    const Vec3 e = 2 * (shape.core_m + shape.rounding_m * Vec3{1, 1, 1}), w = state.angular_velocity_rad_s, v = state.linear_velocity_m_s;
    const Pose pose = pose_of({}, state.orientation);
    const double x = dot(w, pose.axes[0]), y = dot(w, pose.axes[1]), z = dot(w, pose.axes[2]);
    const double turning = (e.y * e.y + e.z * e.z) * x * x + (e.x * e.x + e.z * e.z) * y * y + (e.x * e.x + e.y * e.y) * z * z;
    return kGravity * state.position_m.z + 0.5 * dot(v, v) + turning / 24;
}

// A box may rock on two points for some seconds; it only ever loses energy by that.
TEST(OnSurfaces, ABoxLosesEnergyOnUnevenGroundUntilItRests) {
    for (const bool as_mesh : {false, true}) {
        int still = 0;
        // Boxes of which many would rock on if points that carry were left out for others farther outside, or parts forgot their impulses.
        for (const unsigned seed : {14u, 19u, 31u, 35u, 37u, 45u, 50u, 52u, 54u}) {
            auto scene = rough_ground(as_mesh, {.sleep_ticks = 0});
            drop_box(*scene, seed);
            Workers workers(1);
            run(*scene, 360, 2, workers);
            double least = HUGE_VAL, rise = 0, fastest = 0;
            for (int tick = 360; tick < 2160; ++tick) {
                run(*scene, 1, 2, workers);
                const BodyState state = scene->state(0);
                const double energy = energy_of_box(state, kShapes[seed % 2].second);
                least = std::min(least, energy), rise = std::max(rise, energy - least);
                if (tick >= 1920) fastest = std::max(fastest, length(state.linear_velocity_m_s));
            }
            // Where an edge hits the ground within a step, it comes out again as high as it got in.
            EXPECT_LT(rise, 0.03) << seed << (as_mesh ? " on a mesh" : " on terrain");
            still += fastest < 0.002 ? 1 : 0;
        }
        EXPECT_GE(still, 8);
    }
}

TEST(OnSurfaces, ABoxThatRestsStaysSoWhenContactsAreLaidOutAgain) {
    int rested = 0;
    for (const bool as_mesh : {false, true})
        for (unsigned seed = 0; seed < 8; ++seed) {
            auto scene = rough_ground(as_mesh, {.sleep_ticks = 0});
            drop_box(*scene, seed);
            Workers workers(1);
            run(*scene, 1200, 2, workers);
            const Vec3 place = scene->state(0).position_m;
            if (length(scene->state(0).linear_velocity_m_s) > 1e-3) continue;
            ++rested;
            for (BodyId far = 1; far <= 10; ++far) {
                need(scene->add_body({.id = far, .position_m = {2.0 * far, 40, 90}}));
                run(*scene, 3, 2, workers);
                EXPECT_LT(length(scene->state(0).linear_velocity_m_s), 2e-3) << seed << (as_mesh ? " on a mesh" : " on terrain");
            }
            EXPECT_LT(length(scene->state(0).position_m - place), 1e-3);
        }
    EXPECT_GT(rested, 10);
}

TEST(OnSurfaces, ACrowdOnUnevenGroundStaysOnIt) {
    for (const bool as_mesh : {false, true}) {
        auto scene = rough_ground(as_mesh, {});
        std::mt19937 random(3);
        BodyId id = 0;
        for (int x = 0; x < 5; ++x)
            for (int y = 0; y < 5; ++y, ++id)
                need(scene->add_body({.id = id,
                                      .position_m = {2.2 * x - 4.4, 2.2 * y - 4.4, 1.4},
                                      .orientation = random_turn(random),
                                      .material = 1,
                                      .shape = kShapes[id % 4].second}));
        Workers workers(2);
        run(*scene, 1200, 2, workers);
        int asleep = 0;
        for (BodyId b = 0; b < id; ++b) {
            const BodyState state = scene->state(b);
            EXPECT_GT(state.position_m.z, bumps(state.position_m.x, state.position_m.y) - 0.05) << b;
            EXPECT_LT(state.position_m.z, 1) << b;
            asleep += length(state.linear_velocity_m_s) < 0.02 ? 1 : 0;
        }
        // Cylinders may roll to and fro in hollows for longer.
        EXPECT_GE(asleep, 12);
    }
}

// Where it ends that nothing falls through: a body that is faster than the least thickness of what stops it, or than its own, in a step.
TEST(OnSurfaces, FastBodiesDoNotFallThroughTerrain) {
    for (const double speed : {5.0, 20.0, 60.0, 150.0})
        for (unsigned seed = 0; seed < 10; ++seed) {
            auto scene = make_scene({.sleep_ticks = 0});
            need(scene->add_obstacle(terrain_of(40, 8, bumps), 0));
            std::mt19937 random(seed);
            std::uniform_real_distribution<double> place(-3, 3);
            const Vec3 at{place(random), place(random), 3};
            need(scene->add_body({.id = 0,
                                  .position_m = at,
                                  .orientation = random_turn(random),
                                  .linear_velocity_m_s = {0.3 * speed, 0, -speed},
                                  .shape = kShapes[seed % kShapes.size()].second}));
            Workers workers(1);
            double lowest = HUGE_VAL;
            for (int tick = 0; tick < 60; ++tick) {
                run(*scene, 1, 2, workers);
                const Vec3 now = scene->state(0).position_m;
                if (std::max(std::abs(now.x), std::abs(now.y)) > 7.5) break;
                lowest = std::min(lowest, now.z - bumps(now.x, now.y));
            }
            EXPECT_GT(lowest, 0) << seed << " at " << speed;
        }
}

TEST(OnSurfaces, ABoxStandsOnASlopeOrSlides) {
    for (const double slope : {0.25, 0.35}) {
        auto scene = make_scene({.sleep_ticks = 0});
        const auto material = need(scene->add_material({.friction = 0.3f}));
        need(scene->add_obstacle(grid_mesh(30, 10, 2, [&](double x, double) { return -slope * x; }), material));
        const double angle = std::atan(slope);
        const Vec3 up{std::sin(angle), 0, std::cos(angle)};
        need(scene->add_body({.id = 0,
                              .position_m = Vec3{-3, 0, 3 * slope} + 0.2 * up,
                              .orientation = turn_of(angle, {0, 1, 0}),
                              .material = material,
                              .shape = box_shape({1, 1, 0.4}, 0.02)}));
        Workers workers(1);
        run(*scene, 240, 2, workers);
        const double way = (scene->state(0).position_m.x + 3 - 0.2 * up.x) / std::cos(angle);
        const double wanted = slope < 0.3 ? 0 : 0.5 * kGravity * (std::sin(angle) - 0.3 * std::cos(angle));
        EXPECT_NEAR(way, wanted, 0.01 + 0.02 * wanted) << slope;
    }
}

TEST(OnSurfaces, ABoxStandsOverAnEdgeUntilItsMiddleIsBeyondIt) {
    // A plateau that ends at x = 0 with a fall of 3.
    Mesh cliff{{{-4, -4, 0}, {0, -4, 0}, {0, 4, 0}, {-4, 4, 0}, {0.001, -4, -3}, {0.001, 4, -3}, {6, -4, -3}, {6, 4, -3}},
               {0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2, 4, 6, 7, 4, 7, 5}};
    const Terrain ground = terrain_of(64, 4, [](double x, double) { return x > 1e-9 ? -3.0 : 0.0; });
    for (const Ground& shape : {Ground(cliff), Ground(ground)})
        for (const double middle : {-0.1, 0.12}) {
            auto scene = make_scene({.sleep_ticks = 0});
            need(scene->add_obstacle(shape, 0));
            need(scene->add_body({.id = 0, .position_m = {middle, 0.1, 0.25}, .shape = box_shape({1, 0.6, 0.5}, 0.02)}));
            Workers workers(1);
            run(*scene, 360, 2, workers);
            if (middle < 0) {
                EXPECT_LT(length(scene->state(0).position_m - Vec3{middle, 0.1, 0.25}), 2e-3);
            } else {
                EXPECT_LT(scene->state(0).position_m.z, -2);
            }
        }
}

TEST(OnSurfaces, AMeshHoldsFromBothSides) {
    // A tray with walls: boxes fall into it, and a box that is thrown against its bottom from below comes back.
    auto scene = make_scene({.sleep_ticks = 0});
    need(scene->add_obstacle(grid_mesh(8, 2.4, 1, [](double, double) { return 0.0; }), 0));
    for (const Vec3 normal : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}}) {
        const Vec3 along = cross({0, 0, 1}, normal), at = -2.4 * normal;
        need(scene->add_obstacle(
            Mesh{{at - 2.4 * along, at + 2.4 * along, at + 2.4 * along + Vec3{0, 0, 3}, at - 2.4 * along + Vec3{0, 0, 3}},
                 {0, 1, 2, 0, 3, 2}},
            0));
    }
    for (BodyId id = 0; id < 4; ++id)
        need(scene->add_body({.id = id,
                              .position_m = {1.1 * (id % 2) - 0.55, 1.1 * (id / 2) - 0.55, 1},
                              .orientation = turn_of(0.3 * id, {1, 2, 3}),
                              .linear_velocity_m_s = {3.0 - 2.0 * id, 2.0 * id - 3, 0},
                              .shape = kShapes[id].second}));
    need(scene->add_body(
        {.id = 9, .position_m = {0, 0, -1.5}, .linear_velocity_m_s = {0, 0, 12}, .shape = box_shape({0.5, 0.5, 0.5}, 0.02)}));
    Workers workers(1);
    double highest = -10;
    for (int tick = 0; tick < 600; ++tick) {
        run(*scene, 1, 2, workers);
        if (scene->has(9)) {
            highest = std::max(highest, scene->state(9).position_m.z);
            if (scene->state(9).position_m.z < -6) need(scene->remove_body(9));
        }
    }
    EXPECT_NEAR(highest, -0.25, 0.05);
    EXPECT_FALSE(scene->has(9));
    for (BodyId id = 0; id < 4; ++id) {
        const BodyState state = scene->state(id);
        EXPECT_GT(state.position_m.z, 0.15) << id;
        EXPECT_LT(std::max(std::abs(state.position_m.x), std::abs(state.position_m.y)), 2.3) << id;
        EXPECT_LT(state.position_m.z, 1.5) << id;
    }
}

TEST(OnSurfaces, AFastBoxStopsAtAThinWall) {
    auto scene = make_scene(settings_with({0, 0, 0}, 0));
    need(scene->add_obstacle(Mesh{{{0, -3, -3}, {0, 3, -3}, {0, 3, 3}, {0, -3, 3}}, {0, 1, 2, 0, 2, 3}}, 0));
    need(scene->add_body(
        {.id = 0, .position_m = {-3, 0.2, 0.1}, .linear_velocity_m_s = {60, 0, 0}, .shape = box_shape({0.5, 0.5, 0.5}, 0.02)}));
    Workers workers(1);
    run(*scene, 120, 2, workers);
    EXPECT_LT(scene->state(0).position_m.x, -0.24);
}

// All shapes fall onto bumps and into each other.
std::unique_ptr<Scene> hail(const Settings& settings = {}) {
    auto scene = make_scene(settings);
    need(scene->add_obstacle(terrain_of(24, 6, bumps), 0));
    need(scene->add_obstacle(grid_mesh(6, 1.5, 2, [](double x, double y) { return 1 - 0.3 * (x * x + y * y); }), 0));
    return scene;
}
void add_hail(Scene& scene) {
    std::mt19937 random(4);
    for (BodyId id = 0; id < 72; ++id) {
        BodySpec spec{.id = id, .position_m = {1.5 * (id % 6) - 3.7, 1.5 * (id / 6 % 6) - 3.7, 2.5 + 1.6 * (id / 36)}};
        spec.orientation = random_turn(random);
        if (id % 6 != 5) spec.shape = kShapes[id % 6].second;
        need(scene.add_body(spec));
    }
}

TEST(OnSurfaces, SameBitsForAnyNumberOfWorkersAndAfterASnapshot) {
    expect_same_bits([] { return hail(); }, add_hail);
}

TEST(OnSurfaces, WhatTouchesASurfaceIsToldOnce) {
    auto scene = hail();
    need(scene->add_body({.id = 0, .position_m = {-3, -3, 1.5}, .shape = kShapes[0].second}));
    Workers workers(1);
    int begun = 0, ended = 0;
    for (int tick = 0; tick < 480; ++tick) {
        run(*scene, 1, 2, workers);
        for (const TouchEvent& event : scene->events()) (event.began ? begun : ended) += 1;
        EXPECT_TRUE(begun == ended || begun == ended + 1);
    }
    EXPECT_EQ(begun, ended + 1);
    // It carries its weight, whatever the number of its contacts.
    Vec3 force;
    scene->each_contact([&](const ContactReport& contact) {
        EXPECT_EQ(contact.touch.other, 0u);
        force = force - contact.normal_force_n * contact.normal - contact.friction_n;
    });
    EXPECT_NEAR(std::abs(force.z), kGravity, 0.3);
    EXPECT_LT(std::hypot(force.x, force.y), 0.3);
}

TEST(OnSurfaces, AStartDeepInTheGroundIsRefused) {
    auto scene = make_scene();
    need(scene->add_obstacle(terrain_of(4, 4, [](double, double) { return 0.0; }), 0));
    const auto deep = scene->add_body({.id = 0, .position_m = {0.3, 0.2, -0.3}, .shape = box_shape({1, 1, 1}, 0.02)});
    ASSERT_FALSE(deep);
    EXPECT_NE(deep.error().problem.find("deep in obstacle 0"), std::string::npos) << deep.error().message();
    need(scene->add_body({.id = 0, .position_m = {0.3, 0.2, 0.49}, .shape = box_shape({1, 1, 1}, 0.02)}));
}

}  // namespace
}  // namespace meld::physics::surfaces
