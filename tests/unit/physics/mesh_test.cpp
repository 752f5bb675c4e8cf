// Meshes: surfaces that hold from both sides, whichever way their triangles turn.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "physics/collision/mesh_surface.h"
#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

struct How {
    const char* name;
    Settings settings;
};

// All engines, and both solvers of the first.
std::array<How, 4> engines() {
    const SolverSettings pgs = SolverSettings::pgs20();
    return {{{"soft", {}},
             {"pgs", {.solver = pgs}},
             {"hash", {.engine = EngineKind::Hash, .solver = pgs}},
             {"ode", {.engine = EngineKind::Ode, .solver = pgs}}}};
}

// Squares around the origin, whose two triangles turn like each other or not.
Mesh square(double half, double z, bool first_turned, bool second_turned) {
    Mesh mesh{.points = {{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}}, .triangles = {0, 1, 2, 0, 2, 3}};
    if (first_turned) std::swap(mesh.triangles[1], mesh.triangles[2]);
    if (second_turned) std::swap(mesh.triangles[4], mesh.triangles[5]);
    return mesh;
}

// A cube of this half side, its triangles turned as the bits say.
Mesh cube(double half, unsigned turned) {
    Mesh mesh;
    for (int i = 0; i < 8; ++i) mesh.points.push_back({(i & 1 ? half : -half), (i & 2 ? half : -half), (i & 4 ? half : -half)});
    for (const std::array<std::uint32_t, 4> side :
         {std::array<std::uint32_t, 4>{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
        for (const auto& [b, c] : {std::pair(1, 2), std::pair(2, 3)}) {
            const bool other = turned >> (mesh.triangles.size() / 3) & 1;
            mesh.triangles.push_back(side[0]);
            mesh.triangles.push_back(side[static_cast<std::size_t>(other ? c : b)]);
            mesh.triangles.push_back(side[static_cast<std::size_t>(other ? b : c)]);
        }
    return mesh;
}

TEST(Meshes, HoldFromBothSides) {
    Workers workers(1);
    for (const How& how : engines())
        for (const double up : {1.0, -1.0})
            for (const bool first : {false, true})
                for (const bool second : {false, true}) {
                    Settings settings = how.settings;
                    settings.gravity_m_s2 = {0, 0, -9.81 * up};
                    auto scene = make_scene(settings);
                    need(scene->add_obstacle(square(3, 0, first, second), 0));
                    // On a face, on the edge between both, and beside them.
                    need(scene->add_body({.id = 0, .position_m = {1.2, -0.6, up}}));
                    need(scene->add_body({.id = 1, .position_m = {-0.8, -0.8, up}}));
                    need(scene->add_body({.id = 2, .position_m = {4, 0, up}}));
                    run(*scene, 240, 4, workers);
                    EXPECT_NEAR(up * scene->state(0).position_m.z, 0.5, 0.02) << how.name << up << first << second;
                    EXPECT_NEAR(up * scene->state(1).position_m.z, 0.5, 0.02) << how.name << up << first << second;
                    EXPECT_LT(up * scene->state(2).position_m.z, -1) << how.name;
                }
}

TEST(Meshes, OneTriangleHoldsFromBothSides) {
    Workers workers(1);
    for (const How& how : engines())
        for (const std::vector<std::uint32_t>& triangle : {std::vector<std::uint32_t>{0, 1, 2}, {0, 2, 1}}) {
            auto scene = make_scene(how.settings);
            need(scene->add_obstacle(Mesh{{{-3, -3, 0}, {3, -3, 0}, {0, 4, 0}}, triangle}, 0));
            need(scene->add_body({.id = 0, .position_m = {0, 0, 1.5}}));
            run(*scene, 240, 4, workers);
            EXPECT_NEAR(scene->state(0).position_m.z, 0.5, 0.02) << how.name << triangle[1];
        }
}

// Balls in a cube fly and fall about in it, and never leave; balls beside it never enter.
TEST(Meshes, ClosedOnesHoldInsideAndOutside) {
    Workers workers(2);
    for (const unsigned turned : {0u, 0xfffu, 0x5a3u})
        for (const double speed : {3.0, 100.0, 400.0}) {
            auto scene = make_scene({.sleep_ticks = 0, .max_speed_m_s = 2000});
            const std::uint8_t bouncy = need(scene->add_material({.friction = 0.2f, .restitution = 0.9f}));
            need(scene->add_obstacle(cube(3, turned), bouncy));
            need(scene->add_body({.id = 0, .position_m = {0.3, 0.2, 1}, .linear_velocity_m_s = {speed, 0.7 * speed, 0.3 * speed}}));
            need(scene->add_body({.id = 1, .position_m = {7, 0.2, 6}, .linear_velocity_m_s = {-speed, 0, -0.8 * speed}}));
            bool inside = true, outside = true;
            for (int tick = 0; tick < 480; ++tick) {
                run(*scene, 1, 2, workers);
                const auto farthest = [&](BodyId id) {
                    const Vec3 p = scene->state(id).position_m;
                    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
                };
                inside = inside && farthest(0) < 2.6;
                outside = outside && farthest(1) > 3.4;
            }
            EXPECT_TRUE(inside && outside) << turned << ", " << speed << inside << outside;
        }
}

// The floor and the wall are one mesh: a ball that touches the floor still notices the wall ahead.
TEST(Meshes, FastBallsOnTheFloorMeetTheWall) {
    Workers workers(1);
    for (const bool turned : {false, true})
        for (const double speed : {20.0, 150.0, 700.0}) {
            auto scene = make_scene({.sleep_ticks = 0});
            const std::uint8_t smooth = need(scene->add_material({.friction = 0}));
            Mesh mesh{.points = {{-50, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-50, 5, 0}, {5, -5, 9}, {5, 5, 9}},
                      .triangles = {0, 1, 2, 0, 2, 3, 1, 4, 2, 4, 5, 2}};
            if (turned)
                for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) std::swap(mesh.triangles[i], mesh.triangles[i + 1]);
            need(scene->add_obstacle(mesh, smooth));
            need(scene->add_body({.id = 0, .position_m = {-20, 0.4, 0.5}, .linear_velocity_m_s = {speed, 0, 0}, .material = smooth}));
            double farthest = -20;
            for (int tick = 0; tick < 480; ++tick) {
                run(*scene, 1, 2, workers);
                farthest = std::max(farthest, scene->state(0).position_m.x);
            }
            EXPECT_GT(farthest, 4.3) << speed;
            EXPECT_LT(farthest, 4.51) << speed;
        }
}

class MeshQueries : public testing::Test {
  protected:
    double number(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
    Vec3 point(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
    // Some triangles are lines or points.
    Triangle triangle() {
        Triangle t{point(2), point(2), point(2)};
        if (random_() % 6 == 0) t.c = t.a + number(-1, 2) * (t.b - t.a);
        if (random_() % 12 == 0) t.b = t.c = t.a;
        return t;
    }
    std::mt19937 random_{5};
};

// No point of a grid over the triangle is nearer.
TEST_F(MeshQueries, NearestPointIsTheNearest) {
    for (int n = 0; n < 2000; ++n) {
        const Triangle t = triangle();
        const Vec3 p = point(3), nearest = nearest_point(t, p);
        double least = HUGE_VAL, away = HUGE_VAL;
        for (int i = 0; i <= 40; ++i)
            for (int j = 0; i + j <= 40; ++j) {
                const Vec3 q = t.a + (i / 40.0) * (t.b - t.a) + (j / 40.0) * (t.c - t.a);
                least = std::min(least, length(p - q)), away = std::min(away, length(nearest - q));
            }
        EXPECT_LE(length(p - nearest), least + 1e-9);
        EXPECT_LT(away, 0.2);
    }
}

// The distance to a triangle is convex along a path: halving finds where it becomes the radius.
TEST_F(MeshQueries, ImpactIsWhereTheDistanceBecomesTheRadius) {
    int hits = 0;
    for (int n = 0; n < 8000; ++n) {
        const Triangle t = triangle();
        const Vec3 centre = point(4), path = point(6);
        const double radius = number(0.05, 1);
        const auto gap = [&](double share) { return length(centre + share * path - nearest_point(t, centre + share * path)) - radius; };
        double low = 0, high = 1;
        for (int i = 0; i < 100; ++i) {
            const double one = low + (high - low) / 3, two = high - (high - low) / 3;
            (gap(one) < gap(two) ? high : low) = gap(one) < gap(two) ? two : one;
        }
        const auto impact = impact_on(t, centre, radius, path);
        if (gap(0) <= 0 || gap(low) > 0) {
            // Up to a path that just grazes it.
            EXPECT_TRUE(!impact || gap(low) < 1e-6);
            continue;
        }
        double before = 0, after = low;
        for (int i = 0; i < 60; ++i) {
            const double middle = (before + after) / 2;
            (gap(middle) > 0 ? before : after) = middle;
        }
        if (gap(low) > -1e-9) continue;
        ASSERT_TRUE(impact) << n;
        EXPECT_NEAR(impact->share, after, 1e-5);
        EXPECT_NEAR(length(centre + impact->share * path - impact->point), radius, 1e-6);
        ++hits;
    }
    EXPECT_GT(hits, 200);
}

// As looking at all triangles.
TEST_F(MeshQueries, TreeFindsWhatAllTrianglesHave) {
    int met = 0, touched = 0;
    for (int n = 0; n < 200; ++n) {
        Mesh mesh;
        const int count = 1 + static_cast<int>(random_() % 60);
        for (int i = 0; i < count; ++i)
            for (const Vec3 corner : {triangle().a, triangle().b, triangle().c}) {
                mesh.triangles.push_back(static_cast<std::uint32_t>(mesh.points.size()));
                mesh.points.push_back(corner);
            }
        const MeshSurface surface(mesh);
        for (int m = 0; m < 20; ++m) {
            const Vec3 centre = point(4), path = point(6);
            const double radius = number(0.05, 1);
            double nearest = HUGE_VAL, first = HUGE_VAL;
            for (std::size_t i = 0; i < mesh.points.size(); i += 3) {
                const Triangle t{mesh.points[i], mesh.points[i + 1], mesh.points[i + 2]};
                nearest = std::min(nearest, length(centre - nearest_point(t, centre)) - radius);
                if (const auto impact = impact_on(t, centre, radius, path)) first = std::min(first, impact->share);
            }
            std::array<SurfaceContact, kMaxSurfaceContacts> contacts;
            const int found = surface.collide(mesh, centre, radius, 0.1, contacts);
            ASSERT_EQ(found > 0, nearest < 0.1);
            if (found > 0) {
                EXPECT_EQ(contacts[0].gap_m, nearest);
                ++touched;
            }
            const auto meets = surface.meet(mesh, centre, radius, path, {});
            ASSERT_EQ(meets.has_value(), first <= 1);
            if (!meets) continue;
            EXPECT_NEAR(meets->gap_m, -first * dot(meets->normal, path), 1e-9);
            EXPECT_NEAR(length(meets->normal), 1, 1e-6);
            ++met;
        }
    }
    EXPECT_GT(met, 200);
    EXPECT_GT(touched, 200);
}

// An even floor of many triangles gives one contact, wherever the ball is; a corner of three walls three.
TEST_F(MeshQueries, EvenFacesGiveOneContact) {
    Mesh floor;
    for (int y = 0; y <= 8; ++y)
        for (int x = 0; x <= 8; ++x) floor.points.push_back({0.3 * x, 0.3 * y, 0.1 * x});
    for (std::uint32_t y = 0; y < 8; ++y)
        for (std::uint32_t x = 0; x < 8; ++x) {
            const std::uint32_t at = 9 * y + x;
            floor.triangles.insert(floor.triangles.end(), {at, at + 1, at + 10, at, at + 9, at + 10});
        }
    const MeshSurface surface(floor);
    std::array<SurfaceContact, kMaxSurfaceContacts> contacts;
    for (int n = 0; n < 500; ++n) {
        const double x = number(0.7, 1.7), y = number(0.7, 1.7);
        ASSERT_EQ(surface.collide(floor, {x, y, x / 3 + 0.5}, 0.5, 0.02, contacts), 1);
        EXPECT_NEAR(contacts[0].gap_m, 0.5 * std::cos(std::atan(1.0 / 3)) - 0.5, 1e-9);
    }
    const Mesh corner = cube(3, 0x5a3);
    EXPECT_EQ(MeshSurface(corner).collide(corner, {2.5, 2.5, -2.5}, 0.5, 0.02, contacts), 3);
}

}  // namespace
}  // namespace meld::physics
