#include "runtime/show/render/rounded.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace meld::render {
namespace {

// How far a place is from the cube, negative within it: the definition, to compare with.
float distance(const RoundedCube& cube, const Vec& at) {
    const float inner = cube.half - cube.radius;
    const Vec beyond = (at - cube.middle).cwiseAbs() - Vec::Constant(inner);
    return beyond.cwiseMax(0).norm() + std::min(beyond.maxCoeff(), 0.0F) - cube.radius;
}

// By small steps, each no longer than the distance to the cube.
std::optional<float> by_steps(const RoundedCube& cube, const Vec& from, const Vec& along, float within) {
    float t = 0;
    for (int i = 0; i < 2000 && t < within; ++i) {
        const float away = distance(cube, from + t * along);
        if (away < 2e-5F) return t;
        t += away;
    }
    return std::nullopt;
}

TEST(RoundedCube, IsMetWhereSmallStepsMeetIt) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> any(-1, 1);
    for (const float radius : {0.02F, 0.12F, 0.5F}) {
        const RoundedCube cube{.middle = Vec(3, -2, 1), .half = 0.5F, .radius = radius};
        int met = 0;
        for (int i = 0; i < 20'000; ++i) {
            const Vec from = cube.middle + 2 * Vec(any(random), any(random), any(random)).normalized();
            // Most go close to an edge.
            const Vec along = (cube.middle + 0.75F * Vec(any(random), any(random), any(random)) - from).normalized();
            const auto wanted = by_steps(cube, from, along, 10), got = cube.enters(from, along, 10);
            if (wanted) ++met;
            // A ray that grazes it may be said to miss it, and the other way round.
            float nearest = 10;
            for (float t = 0; t < 4; t += 0.01F) nearest = std::min(nearest, distance(cube, from + t * along));
            if (wanted.has_value() != got.has_value()) {
                EXPECT_LT(std::abs(nearest), 2e-3F) << i;
                continue;
            }
            if (got && nearest < -1e-2F) {
                EXPECT_NEAR(*got, *wanted, 2e-3F) << i << " radius " << radius;
            }
        }
        EXPECT_GT(met, 5'000);
    }
}

TEST(RoundedCube, HasNormalsThatGoOverItsEdgesWithoutSteps) {
    const RoundedCube cube{.radius = 0.1F};
    EXPECT_EQ(cube.normal({0.5F, 0.1F, 0.2F}), Vec(Vec::UnitX()));
    Vec last = Vec::UnitX();
    for (int i = 0; i <= 90; ++i) {
        const float angle = static_cast<float>(i) * std::numbers::pi_v<float> / 180;
        const Vec normal = cube.normal(Vec(0.4F + 0.1F * std::cos(angle), 0.4F + 0.1F * std::sin(angle), 0));
        EXPECT_LT((normal - last).norm(), 0.03F) << i;
        last = normal;
    }
    EXPECT_LT((last - Vec::UnitY()).norm(), 1e-3F);
}

TEST(RoundedCube, IsMetByRaysAlongItsFacesFromFarAway) {
    const RoundedCube cube{.radius = 0.1F};
    EXPECT_NEAR(*cube.enters({-1000, 0.2F, 0.3F}, Vec::UnitX(), 1e6F), 999.5F, 1e-3F);
    EXPECT_NEAR(*cube.enters({0, 0, 0.52F}, -Vec::UnitZ(), 1e6F), 0.02F, 1e-5F);
    EXPECT_FALSE(cube.enters({-1000, 0.51F, 0}, Vec::UnitX(), 1e6F));
    EXPECT_FALSE(cube.enters({-1000, 0, 0}, Vec::UnitX(), 900));
    EXPECT_FALSE(cube.enters({0, 0, 0.502F}, Vec::UnitZ(), 1e6F));
    // Begun inside.
    EXPECT_EQ(cube.enters(Vec::Zero(), Vec::UnitX(), 1), 0.0F);
    // Just within the sharp cube's corner there is nothing.
    EXPECT_FALSE(cube.enters(Vec::Constant(0.49F), Vec::Constant(1).normalized(), 1));
}

TEST(RoundedBox, IsMetWhereSmallStepsMeetIt) {
    std::mt19937 random(4);
    std::uniform_real_distribution<float> any(-1, 1);
    // A plate, a line, a ball and two cylinders, turned.
    for (const Vec& core : {Vec(0.6F, 0.3F, 0.1F), Vec(0, 0, 0.7F), Vec(0, 0, 0), Vec(0.6F, 0, 0.2F), Vec(0.2F, 0, 0.7F)}) {
        const RoundedBody body{core, 0.15F, Eigen::Quaternionf(0.7F, 0.5F, -0.4F, 0.3F).normalized()};
        const RoundedBox box = RoundedBox::of(body, Vec(3, -2, 1));
        const auto away = [&](const Vec& at) {
            const Vec own = (body.turn.conjugate() * (at - box.middle)).cwiseAbs();
            if (body.is_cylinder()) {
                const float out = std::max(own.head<2>().norm() - core.x(), 0.0F), over = std::max(own.z() - core.z(), 0.0F);
                return std::hypot(out, over) - body.rounding;
            }
            const Vec beyond = own - core;
            return beyond.cwiseMax(0).norm() - body.rounding;
        };
        int met = 0;
        for (int i = 0; i < 5'000; ++i) {
            const Vec from = box.middle + 2 * Vec(any(random), any(random), any(random)).normalized();
            const Vec along = (box.middle + 0.8F * Vec(any(random), any(random), any(random)) - from).normalized();
            std::optional<float> wanted;
            float nearest = 10;
            for (float t = 0; t < 6 && !wanted; t += std::max(away(from + t * along), 1e-4F)) {
                nearest = std::min(nearest, away(from + t * along));
                if (nearest < 2e-5F) wanted = t;
            }
            const auto got = box.enters(from, along, 10);
            if (wanted.has_value() != got.has_value()) {
                EXPECT_LT(std::abs(nearest), 2e-3F) << i;
                continue;
            }
            if (!got) continue;
            ++met;
            EXPECT_NEAR(away(from + *got * along), 0, 2e-3F) << i;
            EXPECT_NEAR(*got, *wanted, 0.1F) << i;
            EXPECT_LT(box.normal(from + *got * along).dot(along), 0.05F) << i;
            for (int axis = 0; axis < 3; ++axis) EXPECT_LE(std::abs((from + *got * along - box.middle)[axis]), box.reach()[axis] + 2e-3F);
        }
        EXPECT_GT(met, 100);
    }
}

TEST(RoundedBox, HasTheRimsOfACylinder) {
    const RoundedBody body{Vec(0.4F, 0, 0.9F), 0.1F, Eigen::Quaternionf::Identity()};
    const RoundedBox can = RoundedBox::of(body, Vec::Zero());
    EXPECT_NEAR(*can.enters({-1000, 0, 0.3F}, Vec::UnitX(), 1e6F), 999.5F, 1e-3F);
    EXPECT_NEAR(*can.enters({0.2F, 0.3F, 5}, -Vec::UnitZ(), 10), 4, 1e-5F);
    // Where the box around it has a corner, and where a sharp rim would be.
    EXPECT_FALSE(can.enters({0.45F, 0.45F, 5}, -Vec::UnitZ(), 10));
    EXPECT_FALSE(can.enters({-2, 0.49F, 0.99F}, Vec::UnitX(), 10));
    EXPECT_LT((can.normal({0.3F, 0.4F, 0.2F}) - Vec(0.6F, 0.8F, 0)).norm(), 1e-5F);
    EXPECT_LT((can.normal({0.1F, 0.1F, -1}) + Vec::UnitZ()).norm(), 1e-5F);
    EXPECT_NEAR(body.reach(Vec(0.6F, 0, 0.8F)), 0.4F * 0.6F + 0.9F * 0.8F + 0.1F, 1e-6F);
    EXPECT_FLOAT_EQ(body.least(), 0.5F);
}

}  // namespace
}  // namespace meld::render
