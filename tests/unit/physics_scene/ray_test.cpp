// Rays: where they meet obstacles and bodies, against a walk along them in small steps and against a look at all bodies.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "physics/collision/ray_grid.h"
#include "physics/collision/sight.h"

namespace meld::physics {
namespace {

class Draw {
  public:
    explicit Draw(unsigned seed) : bits_(seed) {}
    double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(bits_); }
    Vec3 point(double far) { return {number(-far, far), number(-far, far), number(-far, far)}; }
    Quat turn() {
        Quat q{number(-1, 1), number(-1, 1), number(-1, 1), number(-1, 1)};
        const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
        return {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
    }
    Ray ray(double far) {
        const Vec3 from = point(far);
        return {from, point(far) - from};
    }
    BodyShape shape() {
        switch (static_cast<int>(number(0, 4))) {
            case 0:
                return {{}, number(0.1, 1)};
            case 1:
                return capsule_shape(number(0.1, 0.5), number(1, 3));
            case 2:
                return cylinder_shape(number(0.1, 1), number(0.2, 2), number(0.01, 0.04));
            default:
                return box_shape({number(0.2, 2), number(0.2, 2), number(0.2, 2)}, number(0, 0.09));
        }
    }

  private:
    std::mt19937_64 bits_;
};

constexpr int kStepsOfWalk = 4000;

// Where a walk in small steps is first inside, as the steps before and at it; nothing if it never is.
std::optional<std::pair<double, double>> walked(const std::function<bool(Vec3)>& inside, const Ray& ray) {
    for (int i = 0; i <= kStepsOfWalk; ++i)
        if (inside(ray.at(static_cast<double>(i) / kStepsOfWalk)))
            return std::pair((i - 1.0) / kStepsOfWalk, static_cast<double>(i) / kStepsOfWalk);
    return std::nullopt;
}

// The walk may step over what the ray hardly touches.
void expect_first(const std::function<bool(Vec3)>& inside, std::optional<double> first, const Ray& ray, int& met) {
    const auto wanted = walked(inside, ray);
    if (!wanted) {
        // It has gone in and out again within a step.
        if (first) {
            EXPECT_FALSE(inside(ray.at(*first + 1.5 / kStepsOfWalk))) << *first;
        }
        return;
    }
    ++met;
    ASSERT_TRUE(first.has_value()) << wanted->second;
    EXPECT_LE(*first, wanted->second + 1e-9);
    // Or it has before.
    if (*first < wanted->first - 1e-9) {
        EXPECT_FALSE(inside(ray.at(*first + 1.5 / kStepsOfWalk)));
    }
}

double square(double x) { return x * x; }

// By the definition of a shape: within its rounding of the core.
bool is_inside(const BodyShape& shape, Vec3 p) {
    const auto beyond = [](double at, double half) { return std::max(std::abs(at) - half, 0.0); };
    const Vec3 half = shape.core_m;
    const double across = shape.is_cylinder() ? square(std::max(std::hypot(p.x, p.y) - half.x, 0.0))
                                              : square(beyond(p.x, half.x)) + square(beyond(p.y, half.y));
    return across + square(beyond(p.z, half.z)) <= square(shape.rounding_m);
}

TEST(Rays, MeetBodiesWhereTheirSurfaceIs) {
    Draw draw(1);
    int met = 0;
    for (int i = 0; i < 3000; ++i) {
        const BodyShape shape = draw.shape();
        const Vec3 centre = draw.point(0.5);
        const Quat turn = draw.turn();
        Ray ray = draw.ray(2.5);
        // Half of them not far from its centre.
        if (i % 2 == 0) ray.way = 1.5 * (centre + draw.point(0.7) - ray.from);
        expect_first([&](Vec3 p) { return is_inside(shape, rotate(conjugate(turn), p - centre)); }, first_on(shape, centre, turn, ray), ray,
                     met);
    }
    EXPECT_GT(met, 500);
}

TEST(Rays, LeaveABodyWhereItsSurfaceIs) {
    Draw draw(2);
    for (int i = 0; i < 500; ++i) {
        const BodyShape shape = draw.shape();
        Vec3 direction = draw.point(1);
        direction = (1 / length(direction)) * direction;
        const double depth = depth_along(shape, direction);
        EXPECT_TRUE(is_inside(shape, (depth - 1e-6) * direction)) << depth;
        EXPECT_FALSE(is_inside(shape, (depth + 1e-6) * direction)) << depth;
    }
}

TEST(Rays, MeetPlanesBoxesAndTerrain) {
    Draw draw(3);
    Terrain terrain{.origin = {-3, -2, 0}, .cell_m = 0.8, .columns = 9, .rows = 6};
    for (int i = 0; i < terrain.columns * terrain.rows; ++i) terrain.heights_m.push_back(draw.number(-1, 1.5));
    Vec3 normal = draw.point(1);
    const Box box{.centre = {0.5, 0.2, -0.3}, .size_m = {1, 2, 0.5}, .orientation = draw.turn()};
    Obstacles obstacles;
    ASSERT_TRUE(obstacles.add(Plane{normal, 0.1}, 0));
    ASSERT_TRUE(obstacles.add(box, 0));
    ASSERT_TRUE(obstacles.add(terrain, 0));
    const auto in_box = [&](Vec3 p) {
        p = rotate(conjugate(box.orientation), p - box.centre);
        return std::abs(p.x) <= 0.5 && std::abs(p.y) <= 1 && std::abs(p.z) <= 0.25;
    };
    int met[3] = {};
    for (int i = 0; i < 1500; ++i) {
        Ray ray = draw.ray(3.5);
        // Some straight down, along a line of the grid, or over a corner of it.
        if (i % 10 == 0) ray.way.x = ray.way.y = 0;
        if (i % 10 == 1) ray.from.x = -3 + 0.8 * 3, ray.way.x = 0;
        if (i % 10 == 2) ray.from = {-3 + 0.8 * 2, -2 + 0.8 * 2, 4}, ray.way = {0.8, 0.8, -6};
        expect_first([&](Vec3 p) { return dot(normal, p) <= 0.1; }, obstacles.first_on(0, ray), ray, met[0]);
        expect_first(in_box, obstacles.first_on(1, ray), ray, met[1]);
        expect_first([&](Vec3 p) { return distance_to(terrain, p, 1e-9) < 0; }, obstacles.first_on(2, ray), ray, met[2]);
    }
    for (const int each : met) EXPECT_GT(each, 50);
}

TEST(Rays, MeetAMeshFromBothSidesAndPassBetweenNoTwoTriangles) {
    // A net of triangles over a square, at heights that are not even.
    Draw draw(4);
    constexpr int kSide = 12;
    Mesh mesh;
    for (int y = 0; y <= kSide; ++y)
        for (int x = 0; x <= kSide; ++x) mesh.points.push_back({x * 0.1, y * 0.1, draw.number(0, 0.3)});
    const auto at = [](int x, int y) { return static_cast<std::uint32_t>(y * (kSide + 1) + x); };
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            for (const std::uint32_t corner : {at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y), at(x, y + 1), at(x + 1, y + 1)})
                mesh.triangles.push_back(corner);
    Obstacles obstacles;
    ASSERT_TRUE(obstacles.add(mesh, 0));
    Terrain same{.origin = {}, .cell_m = 0.1, .columns = kSide + 1, .rows = kSide + 1};
    for (const Vec3 p : mesh.points) same.heights_m.push_back(p.z);
    Obstacles ground;
    ASSERT_TRUE(ground.add(same, 0));
    for (int i = 0; i < 3000; ++i) {
        // Over edges and corners too.
        const double x = i % 3 == 0 ? 0.1 * std::floor(draw.number(1, kSide)) : draw.number(0.05, 1.15);
        const double y = i % 2 == 0 ? 0.1 * std::floor(draw.number(1, kSide)) : draw.number(0.05, 1.15);
        const Ray down{{x, y, 2}, {0, 0, -4}}, up{{x, y, -2}, {0, 0, 4}};
        const auto met = obstacles.first_on(0, down), back = obstacles.first_on(0, up), wanted = ground.first_on(0, down);
        ASSERT_TRUE(met && back && wanted) << x << " " << y;
        EXPECT_NEAR(*met, *wanted, 1e-12);
        EXPECT_NEAR(1 - *back, *wanted, 1e-12);
        EXPECT_FALSE(obstacles.first_on(0, {{x, y, 2}, {0, 0, -1}}).has_value());
    }
}

TEST(Rays, GridFindsWhatALookAtAllFinds) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        Draw draw(seed);
        const bool flat = seed % 2 == 0;
        const double far = seed % 3 == 0 ? 200 : 6;
        RayGrid grid(0.1, 1.8);
        std::vector<std::optional<RayGrid::Thing>> all(120);
        const auto place = [&](RayGrid::Index i) {
            Vec3 at = draw.point(far);
            if (flat) at.z = 0;
            all[i] = RayGrid::Thing{at, draw.shape(), draw.turn()};
            grid.set(i, *all[i]);
        };
        for (RayGrid::Index i = 0; i < all.size(); ++i) place(i);
        int met = 0;
        for (int turn = 0; turn < 300; ++turn) {
            const auto one = static_cast<RayGrid::Index>(draw.number(0, 119.9)), other = static_cast<RayGrid::Index>(draw.number(0, 119.9));
            if (turn % 5 == 0) place(one);
            if (turn % 7 == 0) grid.remove(other), all[other].reset();
            Ray ray = draw.ray(far);
            if (flat) ray.from.z = ray.way.z = 0;
            // Between two of them, too.
            if (turn % 2 == 0 && all[one] && all[other]) ray = {all[one]->centre, all[other]->centre - all[one]->centre};
            // Or through one.
            const RayGrid::Index third = (one + 1) % 120;
            if (turn % 3 == 0 && all[third]) ray.way = 1.2 * (all[third]->centre - ray.from);
            std::optional<double> wanted;
            for (RayGrid::Index i = 0; i < all.size(); ++i) {
                if (!all[i] || i == one || i == other) continue;
                const auto share = first_on(all[i]->shape, all[i]->centre, all[i]->turn, ray);
                if (share && (!wanted || *share < *wanted)) wanted = share;
            }
            met += wanted ? 1 : 0;
            EXPECT_EQ(grid.first_on(ray, one, other), wanted);
            EXPECT_EQ(grid.blocks(ray, one, other), wanted.has_value());
        }
        EXPECT_GT(met, 40);
    }
}

TEST(Rays, SightIsBlockedByThirdBodiesAndObstacles) {
    Obstacles none, wall;
    ASSERT_TRUE(wall.add(Box{.centre = {1, 0, 0}, .size_m = {0.1, 10, 10}}, 0));
    RayGrid grid(0.5, 0.5);
    const BodyShape ball{{}, 0.5};
    grid.set(0, {{0, 0, 0}, ball, {}});
    grid.set(1, {{2, 0, 0}, ball, {}});
    EXPECT_TRUE(in_sight(none, grid, 0, 1));
    EXPECT_FALSE(in_sight(wall, grid, 0, 1));
    grid.set(2, {{1, 0.51, 0}, ball, {}});
    EXPECT_TRUE(in_sight(none, grid, 0, 1));
    grid.set(2, {{1, 0.49, 0}, ball, {}});
    EXPECT_FALSE(in_sight(none, grid, 0, 1));
    EXPECT_TRUE(is_free(none, grid, 0, 1));
    grid.remove(2);
    EXPECT_TRUE(in_sight(none, grid, 1, 0));
}

}  // namespace
}  // namespace meld::physics
