// Bad input and steps that go wrong: an error that names the body, the step and a cure, and the last good state kept.
#include <gtest/gtest.h>
#include <ode/ode.h>

#include "physics/collision/ode_library.h"
#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

TEST(Errors, BodiesThatCannotBeAreRefused) {
    auto scene = make_scene();
    const auto refused = [&](const BodySpec& spec, std::string_view problem) {
        const auto added = scene->add_body(spec);
        ASSERT_FALSE(added);
        EXPECT_EQ(added.error().problem, problem);
        EXPECT_FALSE(added.error().suggestion.empty());
        EXPECT_FALSE(scene->has(spec.id));
    };
    refused({.id = 7, .mass_kg = 0}, "body 7 has the mass 0 kg");
    refused({.id = 7, .mass_kg = -1}, "body 7 has the mass -1 kg");
    refused({.id = 7, .mass_kg = 1e-60}, "body 7 has the mass 1e-60 kg");
    refused({.id = 7, .radius_m = 0}, "body 7 has the radius 0 m");
    refused({.id = 7, .radius_m = std::nan("")}, "body 7 has the radius nan m");
    refused({.id = 7, .inertia_factor = 0}, "body 7 has the inertia factor 0");
    refused({.id = 7, .position_m = {0, HUGE_VAL, 0}}, "body 7 is at (0, inf, 0)");
    refused({.id = 7, .linear_velocity_m_s = {std::nan(""), 0, 0}}, "the velocity of body 7 is not finite");
    refused({.id = 7, .orientation = {0, 0, 0, 0}}, "the orientation of body 7 is no rotation");
    refused({.id = 7, .material = 3}, "body 7 is made of material 3, which does not exist");
    refused({.id = kMaxBodies}, "body 2147483648 has a number that is too large");
    need(scene->add_body({.id = 7}));
    EXPECT_EQ(scene->add_body({.id = 7}).error().problem, "there is already a body 7");
}

TEST(Errors, ActionsOnNobodyAreRefused) {
    auto scene = make_scene();
    need(scene->add_body({.id = 1}));
    EXPECT_EQ(scene->remove_body(5).error().problem, "there is no body 5");
    EXPECT_EQ(scene->set_wrench(5, {}, {}).error().problem, "there is no body 5");
    EXPECT_FALSE(scene->set_wrench(1, {std::nan(""), 0, 0}, {}));
    EXPECT_FALSE(scene->set_state(1, {.position_m = {0, 0, std::nan("")}}));
    EXPECT_FALSE(scene->set_feature_table(1, 1));
    EXPECT_EQ(scene->set_features(1, 1, 0).error().problem, "body 1 has 0 features, and another one is switched");
    need(scene->remove_body(1));
    EXPECT_FALSE(scene->remove_body(1));
}

TEST(Errors, SettingsThatCannotBeAreRefused) {
    Settings settings;
    settings.solver.sweeps = 0;
    EXPECT_EQ(Scene::make(settings).error().problem, "the physics setting sweeps is 0");
    settings = {};
    settings.solver.over_relaxation = 2;
    EXPECT_FALSE(Scene::make(settings));
    settings = {};
    settings.skin_share = 0;
    EXPECT_FALSE(Scene::make(settings));
    settings = {};
    settings.gravity_m_s2.x = std::nan("");
    EXPECT_FALSE(Scene::make(settings));
    auto scene = make_scene();
    Workers workers(1);
    EXPECT_FALSE(scene->step(0, 1, workers));
    EXPECT_FALSE(scene->step(std::nan(""), 1, workers));
    EXPECT_FALSE(scene->step(kTick, 0, workers));
    EXPECT_TRUE(scene->step(kTick, 1, workers));
}

class EnginesGoingWrong : public testing::TestWithParam<EngineKind> {
  protected:
    Workers workers_{2};
};

TEST_P(EnginesGoingWrong, OverlapNamesBothBodiesAndKeepsTheState) {
    auto scene = make_scene({.engine = GetParam()});
    need(scene->add_body({.id = 12, .position_m = {0, 0, 0}}));
    need(scene->add_body({.id = 3, .position_m = {0.3, 0, 0}}));
    need(scene->add_body({.id = 5, .position_m = {9, 0, 0}, .linear_velocity_m_s = {1, 0, 0}}));
    const Digest before = scene->digest();
    const auto report = scene->step(kTick, 2, workers_);
    if (GetParam() == EngineKind::Ode) {
        // ODE pushes any overlap apart.
        EXPECT_TRUE(report);
        return;
    }
    ASSERT_FALSE(report);
    EXPECT_TRUE(report.error().problem.starts_with("step 1: bodies 3 and 12 overlap by 0.7 m, more than 50 % of their radii together"))
        << report.error().message();
    EXPECT_EQ(scene->digest(), before);
    EXPECT_EQ(scene->tick(), 0u);
    // Cured, the scene goes on.
    BodyState state = scene->state(12);
    state.position_m = {0, 3, 0};
    need(scene->set_state(12, state));
    EXPECT_TRUE(scene->step(kTick, 2, workers_));
}

TEST_P(EnginesGoingWrong, ExplodingVelocityNamesTheBodyAndKeepsTheState) {
    auto scene = scene_on_plane({.engine = GetParam()});
    for (BodyId id = 0; id < 20; ++id) need(scene->add_body({.id = id, .position_m = {2.0 * id, 0, 0.5}}));
    run(*scene, 5, 2, workers_);
    const Digest before = scene->digest();
    for (const double force : {1e7, 1e30}) {
        need(scene->set_wrench(9, {force, 0, 0}, {}));
        const auto report = scene->step(kTick, 2, workers_);
        ASSERT_FALSE(report) << force;
        EXPECT_TRUE(report.error().problem.starts_with("step 6: ")) << report.error().message();
        EXPECT_NE(report.error().problem.find("body 9"), std::string::npos) << report.error().message();
        EXPECT_FALSE(report.error().suggestion.empty());
        EXPECT_EQ(scene->digest(), before);
        EXPECT_EQ(scene->tick(), 5u);
    }
    need(scene->set_wrench(9, {}, {}));
    run(*scene, 5, 2, workers_);
    EXPECT_EQ(scene->tick(), 10u);
}

INSTANTIATE_TEST_SUITE_P(Engines, EnginesGoingWrong, testing::Values(EngineKind::Blocks, EngineKind::Hash, EngineKind::Ode),
                         [](const auto& test) {
                             return test.param == EngineKind::Blocks ? "Blocks" : test.param == EngineKind::Hash ? "Hash" : "Ode";
                         });

TEST(Errors, ContactsMayBeAskedForAfterAListThatFailed) {
    auto scene = scene_on_plane();
    add_cube(*scene, 4);
    Workers workers(2);
    run(*scene, 5, 2, workers);
    EXPECT_FALSE(scene->contacts().empty());
    need(scene->add_body({.id = 1000, .position_m = {1e9, 0, 0}}));
    ASSERT_FALSE(scene->step(kTick, 2, workers));
    EXPECT_TRUE(scene->contacts().empty());
    need(scene->remove_body(1000));
    run(*scene, 2, 2, workers);
    EXPECT_FALSE(scene->contacts().empty());
}

TEST(Errors, BodiesTooFarAwayAreNamed) {
    auto scene = make_scene();
    need(scene->add_body({.id = 0}));
    need(scene->add_body({.id = 1, .position_m = {1e9, 0, 0}}));
    Workers workers(1);
    const auto report = scene->step(kTick, 1, workers);
    ASSERT_FALSE(report);
    EXPECT_TRUE(report.error().problem.starts_with("step 1: body 1 is at (1000000000, 0, 0)")) << report.error().message();
    need(scene->remove_body(1));
    EXPECT_TRUE(scene->step(kTick, 1, workers));
}

// A step that fails before anything has moved leaves what was set since the last one.
TEST(Errors, WhatWasSetOutlivesAStepThatDoesNotBegin) {
    for (const EngineKind engine : {EngineKind::Blocks, EngineKind::Hash, EngineKind::Ode}) {
        auto scene = make_scene({.engine = engine});
        for (BodyId id = 0; id < 3; ++id) need(scene->add_body({.id = id, .position_m = {3.0 * id, 0, 0}}));
        Workers workers(1);
        run(*scene, 3, 2, workers);
        // Too far away for the blocks; the others know no limit there, but no step takes no time.
        const bool blocks = engine == EngineKind::Blocks;
        need(scene->set_state(1, {.position_m = {blocks ? 1e9 : 7, 0, 0}, .linear_velocity_m_s = {1, 0, 0}}));
        const Digest set = scene->digest();
        for (int tries = 0; tries < 2; ++tries) {
            EXPECT_FALSE(scene->step(blocks ? kTick : 0, 2, workers));
            EXPECT_EQ(scene->digest(), set);
            EXPECT_EQ(scene->tick(), 3u);
        }
    }
}

TEST(Errors, OdeHasALimit) {
    auto scene = make_scene({.engine = EngineKind::Ode});
    for (BodyId id = 0; id <= kMaxOdeBodies; ++id) need(scene->add_body({.id = id, .position_m = {2.0 * (id % 400), 2.0 * (id / 400), 0}}));
    Workers workers(1);
    EXPECT_EQ(scene->step(kTick, 1, workers).error().problem, "the engine 'ode' holds at most 131072 bodies, not 131073");
}

// ODE ends the process when it meets what it takes for a bug; here it throws, is caught and becomes a value.
TEST(Errors, FatalErrorsOfOdeBecomeExceptions) {
    start_ode();
    EXPECT_THROW(dError(1, "a body of %d sides", 7), OdeFailure);
    EXPECT_THROW(dDebug(1, "assertion"), OdeFailure);
    try {
        dError(1, "a body of %d sides", 7);
    } catch (const OdeFailure& failure) {
        EXPECT_STREQ(failure.what(), "a body of 7 sides");
    }
}

}  // namespace
}  // namespace meld::physics
