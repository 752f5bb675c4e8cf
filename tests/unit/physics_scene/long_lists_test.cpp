// Where few bodies are fast, the list of those that may meet serves many steps, and misses nobody.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "physics/collision/core_contacts.h"
#include "tests/unit/physics/divided_world.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics::long_lists {
namespace {

constexpr int kSide = 24;
const BodyShape kCube = box_shape({0.9, 0.9, 0.9}, 0.02);

// Cubes that lie about on the ground, and some that are thrown among them, with a ball.
void add_cubes(Scene& scene, const std::function<bool(BodyId)>& mine) {
    const auto add = [&](BodySpec spec) {
        if (mine(spec.id)) need(scene.add_body(spec));
    };
    BodyId id = 0;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x, ++id)
            add({.id = id, .position_m = {1.3 * x, 1.3 * y, 0.45}, .orientation = turn_of(0.1 * (x % 7), {0, 0, 1}), .shape = kCube});
    for (int i = 0; i < 5; ++i, ++id) {
        BodySpec spec{.id = id, .position_m = {-2.0 - i, 3.0 + 5 * i, 0.8 + 0.2 * i}, .linear_velocity_m_s = {8.0 - i, 0.3, 1}};
        if (i != 2) spec.shape = kCube;
        spec.angular_velocity_rad_s = {1, 2, 3};
        add(spec);
    }
}

void furnish(Scene& scene, const std::function<bool(BodyId)>& mine) {
    need(scene.add_obstacle(Plane{}, 0));
    add_cubes(scene, mine);
}

Settings settings() {
    Settings settings = settings_for_shapes();
    settings.sleep_ticks = 0;
    return settings;
}

TEST(LongLists, AreMadeSeldom) {
    auto scene = make_scene(settings());
    furnish(*scene, [](BodyId) { return true; });
    Workers workers(1);
    int lists = 0;
    for (int tick = 0; tick < 240; ++tick) lists += need(scene->step(kTick, 2, workers)).rebuilt ? 1 : 0;
    // The fastest would have left half of the skin after every other step.
    EXPECT_GT(lists, 5);
    EXPECT_LT(lists, 60);
}

TEST(LongLists, MissNobody) {
    auto scene = make_scene(settings());
    furnish(*scene, [](BodyId) { return true; });
    Workers workers(1);
    const Core core{kCube.core_m, kCube.rounding_m}, ball{{}, 0.5};
    const auto ids = scene->bodies();
    double deepest_m = 0;
    int touches = 0;
    for (int tick = 0; tick < 150; ++tick) {
        need(scene->step(kTick, 2, workers));
        std::vector<BodyState> states;
        for (const BodyId id : ids) states.push_back(scene->state(id));
        for (std::size_t a = 0; a < states.size(); ++a)
            for (std::size_t b = std::max<std::size_t>(a + 1, kSide * kSide); b < states.size(); ++b) {
                if (length(states[a].position_m - states[b].position_m) > 1.6) continue;
                const auto core_of = [&](std::size_t i) { return ids[i] == kSide * kSide + 2 ? ball : core; };
                AxisHint hint = kNoAxis;
                Manifold found;
                collide(core_of(a), pose_of(states[a].position_m, states[a].orientation), core_of(b),
                        pose_of(states[b].position_m, states[b].orientation), 0, hint, found);
                touches += found.count > 0 ? 1 : 0;
                for (int p = 0; p < found.count; ++p) deepest_m = std::max(deepest_m, -found.points[static_cast<std::size_t>(p)].gap_m);
            }
    }
    EXPECT_GT(touches, 100);
    // A body that is found late would be deep at once: the fastest goes 33 mm in a step.
    EXPECT_LT(deepest_m, 0.02);
}

TEST(LongLists, SameBitsForAnyNumberOfWorkersAndAfterASnapshot) {
    expect_same_bits([] { return scene_on_plane(settings()); }, [](Scene& scene) { add_cubes(scene, [](BodyId) { return true; }); });
}

TEST(LongLists, SameBitsInADividedWorld) {
    auto whole = make_scene(settings());
    furnish(*whole, [](BodyId) { return true; });
    Workers workers(1);
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    Divided divided(3, scattered, furnish, settings());
    for (int tick = 0; tick < 200; ++tick) {
        run(*whole, 1, 2, workers);
        divided.tick();
        if (tick % 20 == 19) {
            ASSERT_EQ(divided.digest(), whole->digest()) << tick;
        }
    }
    EXPECT_LT(divided.rebuilds, 60);
}

}  // namespace
}  // namespace meld::physics::long_lists
