// The same bits for any number of workers and any instruction set; several sizes, obstacles, magnets and sleep at work.
#include <gtest/gtest.h>

#include "physics/bodies/simd.h"
#include "tests/unit/physics/scenes.h"

namespace meld::physics {
namespace {

struct History {
    std::vector<Digest> digests;
    std::vector<TouchEvent> events;
    bool operator==(const History&) const = default;
};

History run_scene(const Settings& settings, int threads) {
    auto scene = scene_on_plane(settings);
    const auto bouncy = need(scene->add_material({.friction = 0.3f, .restitution = 0.4f}));
    need(scene->add_obstacle(Box{.centre = {4, 4, 0.8}, .size_m = {3, 2, 2}, .orientation = {std::cos(0.2), 0, 0, std::sin(0.2)}}, bouncy));
    add_cloud(*scene, 10, 1.2, 23);
    std::vector<Feature> features;
    for (const Vec3 direction : feature_directions(12))
        features.push_back({.direction = direction, .strength = 200, .depth_m = 0.05, .range_m = 0.2});
    features.push_back({.direction = {0, 0, 1}, .kind = FeatureKind::Latch, .strength = 50, .range_m = 0.3});
    const auto table = need(scene->add_feature_table(features));
    for (BodyId id = 0; id < 1000; id += 2) {
        need(scene->set_feature_table(id, table));
        need(scene->set_features(id, 0x1fff, id % 3 == 0 ? 0x555 : 0));
    }
    Workers workers(threads);
    History result;
    for (int tick = 0; tick < 60; ++tick) {
        run(*scene, 1, 2, workers);
        result.digests.push_back(scene->digest());
        result.events.insert(result.events.end(), scene->events().begin(), scene->events().end());
        if (tick == 20) need(scene->remove_body(77));
        if (tick == 30) need(scene->add_body({.id = 5000, .position_m = {5, 5, 30}}));
        if (tick == 40) need(scene->set_features(10, 0, 0));
    }
    return result;
}

TEST(Determinism, SameBitsForAnyNumberOfWorkers) {
    for (const SolverMode mode : {SolverMode::Soft, SolverMode::Pgs}) {
        Settings settings;
        settings.solver = mode == SolverMode::Soft ? SolverSettings{} : SolverSettings::pgs20();
        const History one = run_scene(settings, 1);
        EXPECT_GT(one.events.size(), 300u);
        EXPECT_NE(one.digests[0], one.digests[1]);
        EXPECT_TRUE(run_scene(settings, 2) == one);
        EXPECT_TRUE(run_scene(settings, 4) == one);
    }
}

TEST(Determinism, SameBitsForAnyInstructionSet) {
    const SimdLevel best = simd_level();
    const History one = run_scene({}, 1);
    set_simd_level(SimdLevel::Baseline);
    const History baseline = run_scene({}, 1);
    set_simd_level(best);
    EXPECT_TRUE(baseline == one);
}

TEST(Determinism, SameBitsInAnyOrderOfAdding) {
    const auto digest = [](bool backwards) {
        auto scene = scene_on_plane();
        for (BodyId i = 0; i < 500; ++i) {
            const BodyId id = backwards ? 499 - i : i;
            need(scene->add_body({.id = id,
                                  .position_m = {1.01 * (id % 10), 1.01 * (id / 10 % 10), 0.6 + 1.02 * (id / 100)},
                                  .linear_velocity_m_s = {0.1 * (id % 7), 0, 0}}));
        }
        Workers workers(2);
        run(*scene, 60, 2, workers);
        return scene->digest();
    };
    EXPECT_EQ(digest(false), digest(true));
}

}  // namespace
}  // namespace meld::physics
