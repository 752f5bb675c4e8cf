// Bodies that come farther in a step than they are wide: they hit what is on their way, and nothing else.
#include <gtest/gtest.h>

#include "physics/collision/meeting.h"
#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

TEST(Meeting, IsWhereTheSpheresTouchFirst) {
    const auto head_on = meet({3, 0, 0}, 1, {-4, 0, 0});
    ASSERT_TRUE(head_on);
    EXPECT_NEAR(head_on->normal.x, 1, 1e-15);
    EXPECT_NEAR(head_on->gap_m, 2, 1e-15);
    // Passing at 0.6 they touch where the normal leans by as much; the gap closes after half the path.
    const auto oblique = meet({2.8, 0.6, 0}, 1, {-4, 0, 0});
    ASSERT_TRUE(oblique);
    EXPECT_NEAR(oblique->normal.x, 0.8, 1e-12);
    EXPECT_NEAR(oblique->normal.y, 0.6, 1e-12);
    EXPECT_NEAR(oblique->gap_m, 0.5 * 4 * 0.8, 1e-12);
    EXPECT_FALSE(meet({3, 1.01, 0}, 1, {-9, 0, 0}));
    EXPECT_FALSE(meet({3, 0, 0}, 1, {4, 0, 0}));
    EXPECT_FALSE(meet({3, 0, 0}, 1, {-1.9, 0, 0}));
    EXPECT_FALSE(meet({0.5, 0, 0}, 1, {-4, 0, 0}));
}

class FastBodies : public testing::Test {
  protected:
    std::unique_ptr<Scene> scene(float restitution) {
        auto made = make_scene({.gravity_m_s2 = {}, .sleep_ticks = 0});
        material_ = need(made->add_material({.friction = 0, .restitution = restitution}));
        return made;
    }
    void add(Scene& scene, BodyId id, Vec3 position, Vec3 velocity) {
        need(scene.add_body({.id = id, .position_m = position, .linear_velocity_m_s = velocity, .material = material_}));
    }
    std::uint8_t material_ = 0;
    Workers workers_{1};
};

// From everywhere within a step's path, so that whether a step ends inside the other ball does not matter.
TEST_F(FastBodies, ExchangeVelocitiesHeadOn) {
    for (const double speed : {50.0, 150.0, 210.0, 400.0, 950.0})
        for (double start = -8; start < -7; start += 0.23) {
            auto balls = scene(1);
            add(*balls, 0, {start, 0, 0}, {speed, 0, 0});
            add(*balls, 1, {0, 0, 0}, {});
            run(*balls, 48, 2, workers_);
            EXPECT_NEAR(balls->state(0).linear_velocity_m_s.x, 0, 1e-3 * speed) << speed << " from " << start;
            EXPECT_NEAR(balls->state(1).linear_velocity_m_s.x, speed, 1e-3 * speed) << speed << " from " << start;
        }
}

TEST_F(FastBodies, BothMayBeFast) {
    for (double start = -8; start < -7; start += 0.31) {
        auto balls = scene(1);
        add(*balls, 0, {start, 0, 0}, {450, 0, 0});
        add(*balls, 1, {7, 0, 0}, {-400, 0, 0});
        run(*balls, 30, 2, workers_);
        EXPECT_NEAR(balls->state(0).linear_velocity_m_s.x, -400, 1);
        EXPECT_NEAR(balls->state(1).linear_velocity_m_s.x, 450, 1);
    }
}

TEST_F(FastBodies, DeflectAtTheAngleAtWhichTheyMeet) {
    for (const double aside : {0.3, 0.7, 0.9}) {
        auto balls = scene(1);
        const double speed = 500;
        add(*balls, 0, {-9.3, aside, 0}, {speed, 0, 0});
        add(*balls, 1, {0, 0, 0}, {});
        run(*balls, 15, 2, workers_);
        const double along = std::sqrt(1 - aside * aside);
        EXPECT_NEAR(length(balls->state(1).linear_velocity_m_s), speed * along, 0.01 * speed) << aside;
        EXPECT_NEAR(-balls->state(1).linear_velocity_m_s.y, speed * along * aside, 0.01 * speed) << aside;
        EXPECT_NEAR(balls->kinetic_energy_j(), speed * speed / 2, 1e-3 * speed * speed) << aside;
    }
}

TEST_F(FastBodies, PassWhatTheyMiss) {
    auto balls = scene(1);
    add(*balls, 0, {-9.3, 1.02, 0}, {600, 0, 0});
    for (BodyId id = 1; id < 10; ++id) add(*balls, id, {2.0 * id - 6, 0, 0}, {});
    run(*balls, 15, 2, workers_);
    EXPECT_EQ(balls->state(0).linear_velocity_m_s.x, 600);
    EXPECT_EQ(balls->state(0).linear_velocity_m_s.y, 0);
}

// Without restitution both go on together.
TEST_F(FastBodies, MomentumStaysInInelasticHits) {
    for (const double speed : {210.0, 800.0}) {
        auto balls = scene(0);
        add(*balls, 0, {-8.4, 0, 0}, {speed, 0, 0});
        add(*balls, 1, {0, 0, 0}, {});
        run(*balls, 30, 2, workers_);
        EXPECT_NEAR(balls->momentum().x, speed, 1e-3 * speed);
        EXPECT_NEAR(balls->state(0).linear_velocity_m_s.x, speed / 2, 0.02 * speed);
    }
}

// A sheet of balls two deep, without holes: none of a volley gets through.
TEST_F(FastBodies, DoNotGetThroughASheet) {
    for (const double speed : {210.0, 350.0}) {
        auto balls = scene(0.5f);
        BodyId id = 0;
        for (int layer = 0; layer < 2; ++layer)
            for (int y = -8; y < 8; ++y)
                for (int z = -8; z < 8; ++z)
                    need(balls->add_body({.id = id++, .position_m = {0.8 * layer, y + 0.5 * layer, z + 0.5 * layer}, .fixed = true}));
        const BodyId first = id;
        std::mt19937 random(11);
        std::uniform_real_distribution<double> back(-3, 0);
        for (int i = 0; i < 36; ++i) add(*balls, id++, {-6 + back(random), 1.37 * (i % 6) - 3, 1.37 * (i / 6) - 3}, {speed, 0, 0});
        run(*balls, 24, 2, workers_);
        for (BodyId ball = first; ball < id; ++ball) EXPECT_LT(balls->state(ball).position_m.x, 0.5) << speed << ", " << ball;
    }
}

}  // namespace
}  // namespace meld::physics
