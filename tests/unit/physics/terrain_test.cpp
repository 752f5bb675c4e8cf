// Balls on terrain: the nearest contact against all points of the surface, and pours and fast balls that must not get through.
#include "physics/collision/terrain.h"

#include <gtest/gtest.h>

#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

// One cell of two diameters, twisted: ODE found no contact with its middle.
Terrain twisted_cell() { return {.origin = {0, 0, 0}, .cell_m = 2, .columns = 2, .rows = 2, .heights_m = {-0.13, -0.24, 0.13, 0.25}}; }

// Hills as steep as 45 degrees between walls that are steeper.
Terrain basin() {
    Terrain terrain{.origin = {-14, -14, 0}, .cell_m = 1.75, .columns = 17, .rows = 17};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> height(-0.5, 0.5);
    for (int row = 0; row < 17; ++row)
        for (int column = 0; column < 17; ++column) {
            const int edge = std::min({row, column, 16 - row, 16 - column});
            terrain.heights_m.push_back(edge < 3 ? 4.0 * (3 - edge) : height(random));
        }
    return terrain;
}

// The height of the two triangles of the cell that a place is in.
double height_of(const Terrain& terrain, double x, double y) {
    const double u = (x - terrain.origin.x) / terrain.cell_m, v = (y - terrain.origin.y) / terrain.cell_m;
    const int i = std::clamp(static_cast<int>(u), 0, terrain.columns - 2), j = std::clamp(static_cast<int>(v), 0, terrain.rows - 2);
    const auto h = [&](int a, int b) { return terrain.heights_m[static_cast<std::size_t>((j + b) * terrain.columns + i + a)]; };
    const double s = u - i, t = v - j;
    return terrain.origin.z + (s >= t ? h(0, 0) + s * (h(1, 0) - h(0, 0)) + t * (h(1, 1) - h(1, 0))
                                      : h(0, 0) + t * (h(0, 1) - h(0, 0)) + s * (h(1, 1) - h(0, 1)));
}

double distance_by_sampling(const Terrain& terrain, Vec3 point, double range) {
    double least = range;
    constexpr int kSamples = 300;
    for (int i = 0; i <= kSamples; ++i)
        for (int j = 0; j <= kSamples; ++j) {
            const double x = point.x + range * (2.0 * i / kSamples - 1), y = point.y + range * (2.0 * j / kSamples - 1);
            const double width = (terrain.columns - 1) * terrain.cell_m, depth = (terrain.rows - 1) * terrain.cell_m;
            if (x < terrain.origin.x || y < terrain.origin.y || x > terrain.origin.x + width || y > terrain.origin.y + depth) continue;
            least = std::min(least, length(point - Vec3{x, y, height_of(terrain, x, y)}));
        }
    return least;
}

TEST(TerrainContacts, TheNearestIsTheNearestOfTheWholeSurface) {
    std::mt19937 random(3);
    for (const Terrain& terrain : {twisted_cell(), basin()}) {
        const double width = (terrain.columns - 1) * terrain.cell_m;
        std::uniform_real_distribution<double> place(0.1 * width, 0.9 * width), above(0.05, 0.9);
        for (int i = 0; i < 40; ++i) {
            Vec3 centre = terrain.origin + Vec3{place(random), place(random), 0};
            centre.z = height_of(terrain, centre.x, centre.y) + above(random);
            std::array<SurfaceContact, kMaxSurfaceContacts> contacts;
            const int count = collide(terrain, centre, 0.5, 0.5, contacts);
            ASSERT_GE(count, 1);
            const double expected = distance_by_sampling(terrain, centre, 1) - 0.5;
            EXPECT_LE(contacts[0].gap_m, expected + 1e-9);
            EXPECT_GE(contacts[0].gap_m, expected - 0.01);
            EXPECT_NEAR(length(contacts[0].normal), 1, 1e-9);
        }
    }
}

TEST(TerrainContacts, EvenGroundIsOneContactAlsoAtTheEdgesOfTriangles) {
    const Terrain flat{.cell_m = 0.3, .columns = 11, .rows = 11, .heights_m = std::vector<double>(121, 1.0)};
    for (const double x : {1.0, 1.2, 1.35, 1.5})
        for (const double y : {1.05, 1.2, 1.5}) {
            std::array<SurfaceContact, kMaxSurfaceContacts> contacts;
            ASSERT_EQ(collide(flat, {x, y, 1.45}, 0.5, 0.1, contacts), 1) << x << ", " << y;
            EXPECT_NEAR(contacts[0].normal.z, 1, 1e-9);
            EXPECT_NEAR(contacts[0].gap_m, -0.05, 1e-9);
        }
}

TEST(TerrainContacts, AValleyIsTwoContacts) {
    const Terrain valley{.cell_m = 1, .columns = 3, .rows = 2, .heights_m = {1, 0, 1, 1, 0, 1}};
    std::array<SurfaceContact, kMaxSurfaceContacts> contacts;
    ASSERT_EQ(collide(valley, {1, 0.4, 0.5 * std::sqrt(2.0)}, 0.5, 0.01, contacts), 2);
    for (const int i : {0, 1}) EXPECT_NEAR(contacts[static_cast<std::size_t>(i)].normal.z, std::sqrt(0.5), 1e-9);
    EXPECT_NEAR(dot(contacts[0].normal, contacts[1].normal), 0, 1e-9);
}

TEST(TerrainContacts, ABallRestsOnACoarseTwistedCell) {
    for (const EngineKind engine : {EngineKind::Blocks, EngineKind::Hash, EngineKind::Ode}) {
        auto scene = make_scene({.engine = engine, .linear_damping_per_s = 8, .angular_damping_per_s = 8});
        need(scene->add_obstacle(twisted_cell(), 0));
        need(scene->add_body({.id = 0, .position_m = {0.5, 0.4, 1}}));
        Workers workers(1);
        run(*scene, 240, 2, workers);
        const Vec3 p = scene->state(0).position_m;
        EXPECT_NEAR(distance_to(twisted_cell(), p, 2), 0.5, 0.01) << static_cast<int>(engine);
    }
}

// ODE's own height field lost some.
TEST(TerrainContacts, TheEngineOdeLosesNoBallEither) {
    auto scene = make_scene({.engine = EngineKind::Ode});
    const Terrain terrain = basin();
    need(scene->add_obstacle(terrain, 0));
    for (BodyId id = 0; id < 300; ++id)
        need(scene->add_body({.id = id,
                              .position_m = {0.55 * (id % 17) - 4.5, 0.55 * (id / 17) - 4.5, 2},
                              .linear_velocity_m_s = {0.5 * (id % 3) - 0.5, 0.5 * (id % 5) - 1, -4},
                              .radius_m = 0.25}));
    Workers workers(1);
    run(*scene, 240, 2, workers);
    for (const BodyId id : scene->bodies()) {
        const Vec3 p = scene->state(id).position_m;
        EXPECT_GT(p.z, height_of(terrain, p.x, p.y)) << id;
    }
}

TEST(TerrainContacts, APourLosesNoBall) {
    auto scene = make_scene();
    const Terrain terrain = basin();
    need(scene->add_obstacle(terrain, 0));
    for (BodyId id = 0; id < 3000; ++id)
        need(scene->add_body({.id = id,
                              .position_m = {0.55 * (id % 17) - 4.5, 0.55 * (id / 17 % 17) - 4.5, 2 + 0.55 * (id / 289)},
                              .linear_velocity_m_s = {0.5 * (id % 3) - 0.5, 0.5 * (id % 5) - 1, -4},
                              .radius_m = 0.25}));
    Workers workers(2);
    run(*scene, 480, 2, workers);
    for (const BodyId id : scene->bodies()) {
        const Vec3 p = scene->state(id).position_m;
        EXPECT_GT(p.z, height_of(terrain, p.x, p.y)) << id;
    }
}

TEST(TerrainContacts, FastBallsStopAtTheSurface) {
    for (const double v : {30.0, 150.0, 600.0}) {
        auto scene = make_scene({.gravity_m_s2 = {}});
        const Terrain terrain = basin();
        need(scene->add_obstacle(terrain, 0));
        need(scene->add_body({.id = 0, .position_m = {0.3, 0.2, 20}, .linear_velocity_m_s = {0.1 * v, 0, -v}, .radius_m = 0.25}));
        Workers workers(1);
        for (int tick = 0; tick < 240; ++tick) {
            run(*scene, 1, 2, workers);
            ASSERT_GT(distance_to(terrain, scene->state(0).position_m, 1), 0.2) << v;
        }
    }
}

}  // namespace
}  // namespace meld::physics
