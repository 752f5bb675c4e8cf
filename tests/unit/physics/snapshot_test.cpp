// A scene that is saved and loaded between any two steps goes on as if nothing had happened: the same bits, events and lists.
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <set>

#include "physics/solver/engine.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics {
namespace {

using Make = std::function<std::unique_ptr<Scene>()>;

bool knows(const Scene& scene, const Touch& touch) { return scene.has(touch.body) && (touch.other_is_obstacle || scene.has(touch.other)); }

// Of all contacts but those of removed bodies, with the signs of zeros. Normal forces count the bounces of the last step, which no other
// step needs.
std::vector<std::byte> bits_of_contacts(Scene& scene) {
    std::vector<ContactReport> contacts(scene.contacts().begin(), scene.contacts().end());
    std::erase_if(contacts, [&](const ContactReport& contact) { return !knows(scene, contact.touch); });
    for (ContactReport& contact : contacts) contact.normal_force_n = 0;
    const auto bits = std::as_bytes(std::span(contacts));
    return {bits.begin(), bits.end()};
}

std::unique_ptr<Scene> saved_and_loaded(Scene& scene, const Make& make, Workers& workers) {
    const SavedScene bytes = saved(scene);
    auto other = loaded(bytes, make(), workers);
    // All that was saved came back, also what no step shows soon.
    EXPECT_EQ(saved(*other), bytes);
    EXPECT_EQ(other->digest(), scene.digest());
    EXPECT_EQ(other->tick(), scene.tick());
    EXPECT_EQ(other->awake_bodies(), scene.awake_bodies());
    // Other engines report contacts of their steps only.
    if (scene.world().settings.engine == EngineKind::Blocks) {
        EXPECT_TRUE(bits_of_contacts(*other) == bits_of_contacts(scene));
    }
    return other;
}

using Events = std::vector<TouchEvent>;

Events events(const Scene& scene) { return {scene.events().begin(), scene.events().end()}; }

Events without_removed(Events all, const Scene& scene) {
    std::erase_if(all, [&](const TouchEvent& e) { return !knows(scene, e.touch); });
    return all;
}

// Steps a scene, and beside it scenes that were loaded from what it was after these ticks, for a while. `act` acts on all of them before a
// step.
void follow(Scene& scene, const Make& make, int ticks, const std::set<int>& saved_after, const std::function<void(Scene&, int)>& act,
            double dt_s = kTick) {
    constexpr int kFor = 25;
    Workers workers(1), two(2);
    std::map<int, std::unique_ptr<Scene>> loaded;
    for (int tick = 0; tick <= ticks; ++tick) {
        act(scene, tick);
        if (saved_after.contains(tick)) loaded[tick] = saved_and_loaded(scene, make, workers);
        std::erase_if(loaded, [&](const auto& each) { return each.first + kFor < tick; });
        const auto report = scene.step(dt_s, 2, workers);
        ASSERT_TRUE(report) << report.error().message();
        for (auto& [since, other] : loaded) {
            SCOPED_TRACE("tick " + std::to_string(tick) + ", loaded after tick " + std::to_string(since));
            if (since != tick) act(*other, tick);
            const auto again = other->step(dt_s, 2, since % 2 == 0 ? two : workers);
            ASSERT_TRUE(again) << again.error().message();
            EXPECT_EQ(again->rebuilt, report->rebuilt);
            EXPECT_EQ(again->candidates, report->candidates);
            EXPECT_EQ(again->awake_bodies, report->awake_bodies);
            EXPECT_EQ(again->tick, report->tick);
            // Touches of what was removed before it was saved end without an event.
            EXPECT_EQ(events(*other), since == tick ? without_removed(events(scene), scene) : events(scene));
            for (const BodyId body : scene.bodies()) ASSERT_EQ(other->energy_drawn_j(body), scene.energy_drawn_j(body)) << body;
            ASSERT_EQ(other->digest(), scene.digest());
            ASSERT_TRUE(saved(*other) == saved(scene));
        }
    }
}

std::set<int> every(int ticks, int until) {
    std::set<int> all = {0, 1};
    for (int tick = ticks; tick < until; tick += ticks) all.insert(tick);
    return all;
}

std::unique_ptr<Scene> cloud_scene(const Settings& settings) {
    auto scene = scene_on_plane(settings);
    const auto bouncy = need(scene->add_material({.friction = 0.3f, .restitution = 0.4f}));
    need(scene->add_obstacle(Box{.centre = {4, 4, 0.8}, .size_m = {3, 2, 2}, .orientation = {std::cos(0.2), 0, 0, std::sin(0.2)}}, bouncy));
    Terrain hills{.origin = {-9, -9, 0.2}, .cell_m = 1.7, .columns = 17, .rows = 17};
    for (int i = 0; i < 17 * 17; ++i) hills.heights_m.push_back(0.1 * (i * i % 7));
    need(scene->add_obstacle(hills, 0));
    std::vector<Feature> features;
    for (const Vec3 direction : feature_directions(12))
        features.push_back({.direction = direction, .strength = 200, .depth_m = 0.05, .range_m = 0.2, .power_w = 1});
    features.push_back({.direction = {0, 0, 1}, .kind = FeatureKind::Latch, .strength = 50, .range_m = 0.3});
    for (const Vec3 direction : feature_directions(6))
        features.push_back(
            {.direction = direction, .kind = FeatureKind::Plate, .strength = 500, .area_m2 = 0.1, .cover_m = 1e-3, .range_m = 0.2});
    need(scene->add_feature_table(features));
    return scene;
}

struct Kind {
    const char* name;
    EngineKind engine;
    SolverSettings solver;
};

class SnapshotOfEngine : public testing::TestWithParam<Kind> {};

// Bodies of several sizes with magnets, plates and latches; some are removed, pushed and switched, also right before it is saved.
TEST_P(SnapshotOfEngine, GoesOn) {
    Settings settings;
    settings.engine = GetParam().engine;
    settings.solver = GetParam().solver;
    const Make make = [&] { return cloud_scene(settings); };
    auto scene = make();
    const int side = settings.engine == EngineKind::Blocks ? 8 : 5;
    add_cloud(*scene, side, 1.2, 23);
    const auto bodies = static_cast<BodyId>(side * side * side);
    for (BodyId id = 0; id < bodies; id += 2) {
        need(scene->set_feature_table(id, 1));
        need(scene->set_features(id, 0x7ffff, id % 3 == 0 ? 0x555 : 0));
    }
    // One comes from far away, faster than its diameter in a step. One is hollow; one is fixed, and the zeros of its velocity have signs.
    need(scene->add_body({.id = bodies, .position_m = {60, 4, 4}, .linear_velocity_m_s = {-300, 0, 0}, .radius_m = 0.4}));
    need(scene->add_body(
        {.id = bodies + 1, .position_m = {-3, 3, 3}, .angular_velocity_rad_s = {3, 1, 2}, .radius_m = 0.4, .inertia_factor = 2.0 / 3}));
    need(scene->add_body({.id = bodies + 2,
                          .position_m = {-3, 3, 2},
                          .linear_velocity_m_s = {-0.0, 0.1, -0.0},
                          .angular_velocity_rad_s = {-0.0, -0.0, 0.1},
                          .radius_m = 0.4,
                          .fixed = true}));
    // Two whose plates face each other, with opposite voltages.
    for (const BodyId id : {bodies + 3, bodies + 4}) {
        need(scene->add_body({.id = id, .position_m = {-4, 6, 5 + 0.85 * (id - bodies)}, .radius_m = 0.4}));
        need(scene->set_feature_table(id, 1));
        need(scene->set_features(id, 0x7ffff, id % 2 == 0 ? 0x7e000 : 0));
    }
    const auto act = [](Scene& one, int tick) {
        if (tick == 20) need(one.remove_body(77));
        if (tick == 21) need(one.remove_body(30));
        if (tick == 28) need(one.set_features(10, 0, 0));
        if (tick == 33) need(one.set_wrench(12, {0, 0, 60}, {1, 0, 0}));
        if (tick == 35) need(one.set_wrench(12, {0, 0, 0}, {}));
    };
    follow(*scene, make, 60, {0, 1, 10, 20, 21, 25, 34, 35, 48}, act);
    if (HasFailure()) return;
    EXPECT_GT(scene->energy_drawn_j(0), 0);
}

INSTANTIATE_TEST_SUITE_P(Engines, SnapshotOfEngine,
                         testing::Values(Kind{"soft", EngineKind::Blocks, {}}, Kind{"pgs", EngineKind::Blocks, SolverSettings::pgs20()},
                                         Kind{"ode", EngineKind::Ode, {}}),
                         [](const auto& kind) { return kind.param.name; });

// A pile that falls asleep around a ball that swings in the field of a magnet, and is then hit.
TEST(Snapshot, KnowsWhatSleepsAndRattles) {
    const Make make = [] {
        auto scene = scene_on_plane();
        need(scene->add_material({.friction = 0}));
        need(scene->add_feature_table(
            {{.direction = {0, 0, 1}, .strength = 50, .range_m = 0.5}, {.direction = {0, 0, -1}, .strength = 50, .range_m = 0.5}}));
        return scene;
    };
    auto scene = make();
    add_cube(*scene, 4);
    need(scene->add_body({.id = 64, .position_m = {6, 1.5, 1.6}, .material = 1, .fixed = true}));
    need(scene->add_body({.id = 65, .position_m = {6.004, 1.5, 0.5}, .material = 1}));
    for (const BodyId id : {64u, 65u}) need(scene->set_feature_table(id, 1));
    need(scene->set_features(64, 2, 0));
    need(scene->set_features(65, 1, 1));
    bool slept = false, woke = false;
    const auto act = [&](Scene& one, int tick) {
        slept = slept || one.awake_bodies() == 0;
        woke = woke || (slept && one.awake_bodies() > 0);
        if (tick != 1000) return;
        BodyState state = one.state(63);
        state.linear_velocity_m_s = {3, 0, 4};
        need(one.set_state(63, state));
    };
    std::set<int> saved = every(37, 1030);
    saved.insert({999, 1000, 1001, 1002, 1010});
    follow(*scene, make, 1060, saved, act);
    EXPECT_TRUE(slept && woke);
}

// A ball that turns round at the end of its way up a gentle slope, and is watched there.
TEST(Snapshot, KnowsWhatTurnsRound) {
    const Make make = [] { return scene_on_plane({.gravity_m_s2 = {-0.02, 0, -9.81}}); };
    auto scene = make();
    need(
        scene->add_body({.id = 0, .position_m = {0, 0, 0.5}, .linear_velocity_m_s = {0.01, 0, 0}, .angular_velocity_rad_s = {0, 0.02, 0}}));
    need(scene->add_body({.id = 1, .position_m = {0, 300, 5}, .linear_velocity_m_s = {1, 0, 0}, .fixed = true}));
    follow(*scene, make, 400, every(7, 400), [](Scene&, int) {});
    EXPECT_LT(scene->state(0).linear_velocity_m_s.x, -0.01);
}

// A list that is made while a pile sleeps serves it when it wakes.
TEST(Snapshot, KnowsAListThatWasMadeWhileAPileSlept) {
    const Make make = [] { return scene_on_plane({.sleep_ticks = 5}); };
    auto scene = make();
    add_cube(*scene, 4);
    need(scene->add_body({.id = 100, .position_m = {80, 0, 60}}));
    bool slept = false;
    const auto act = [&](Scene& one, int tick) {
        slept = slept || one.asleep(0);
        if (tick != 200) return;
        BodyState state = one.state(63);
        state.linear_velocity_m_s = {0, 0, -2};
        need(one.set_state(63, state));
    };
    follow(*scene, make, 240, {0, 1, 40, 80, 120, 160, 190, 199, 200, 201, 210}, act);
    EXPECT_TRUE(slept);
}

class SnapshotOfTouches : public testing::TestWithParam<EngineKind> {};

// One that touches bodies and the ground is removed before the scene is saved: nothing that is loaded names it any more.
TEST_P(SnapshotOfTouches, ForgetsThoseOfRemovedBodies) {
    const Make make = [] { return scene_on_plane({.engine = GetParam()}); };
    auto scene = make();
    add_cube(*scene, 3, 0.999);
    Workers workers(1);
    run(*scene, 2, 2, workers);
    ASSERT_FALSE(scene->contacts_of(0).empty());
    need(scene->remove_body(0));
    auto loaded = saved_and_loaded(*scene, make, workers);
    for (Scene* each : {scene.get(), loaded.get()}) run(*each, 1, 2, workers);
    EXPECT_FALSE(events(*scene).empty());
    EXPECT_EQ(events(*loaded), without_removed(events(*scene), *scene));
    EXPECT_EQ(loaded->digest(), scene->digest());
}

INSTANTIATE_TEST_SUITE_P(Engines, SnapshotOfTouches, testing::Values(EngineKind::Blocks, EngineKind::Ode, EngineKind::Hash));

// Bodies of composites are killed and released just before the scene is saved, so that the composites end in the next step, or stay.
TEST(Snapshot, KnowsCompositesThatEndInTheNextStep) {
    const auto make = [] { return scene_on_plane(); };
    using Change = void (*)(Scene&);
    const Change changes[] = {
        [](Scene& scene) { need(scene.remove_body(0)); },
        [](Scene& scene) { need(scene.remove_body(5)); },
        [](Scene& scene) { need(scene.remove_body(9)), need(scene.remove_body(21)); },
        [](Scene& scene) { need(scene.release(3, 4)), need(scene.release(20, 21)); },
        [](Scene& scene) { need(scene.release(3, 4)), need(scene.connect(3, 4)); },
        [](Scene& scene) { need(scene.remove_body(20)), need(scene.release(6, 7)), need(scene.connect(9, 21)); },
    };
    Workers workers(1);
    for (const Change& change : changes) {
        auto scene = make();
        for (BodyId id = 0; id < 10; ++id)
            need(scene->add_body({.id = id, .position_m = {double(id), 0, 3 + 0.1 * id}, .linear_velocity_m_s = {0, 0.3 * id, 0}}));
        // And a pair beside them.
        for (const BodyId id : {20u, 21u}) need(scene->add_body({.id = id, .position_m = {double(id) - 11, 1, 2}}));
        for (BodyId id = 1; id < 10; ++id) need(scene->connect(id - 1, id));
        need(scene->connect(20, 21));
        run(*scene, 30, 2, workers);
        change(*scene);
        auto loaded = saved_and_loaded(*scene, make, workers);
        for (int tick = 0; tick < 60; ++tick) {
            for (Scene* each : {scene.get(), loaded.get()}) run(*each, 1, 2, workers);
            ASSERT_EQ(loaded->digest(), scene->digest()) << &change - changes << ", tick " << tick;
        }
    }
}

// A row leans on a wall. A fixed body that turns beyond its end keeps the blocks there awake, which push those that sleep.
TEST(Snapshot, KnowsSleepersOnWhichOthersLean) {
    const Make make = [] {
        auto scene = scene_on_plane({.gravity_m_s2 = {-3, 0, -9.81}, .sleep_ticks = 5});
        need(scene->add_obstacle(Box{.centre = {-1, 0, 2}, .size_m = {1, 4, 4}}, 0));
        return scene;
    };
    auto scene = make();
    for (BodyId id = 0; id < 40; ++id) need(scene->add_body({.id = id, .position_m = {double(id), 0, 0.5}}));
    need(scene->add_body({.id = 40, .position_m = {42, 0, 0.5}, .angular_velocity_rad_s = {0, 0, 0.001}, .fixed = true}));
    bool beside = false;
    const auto act = [&](Scene& one, int) { beside = beside || (one.asleep(0) && !one.asleep(39)); };
    follow(*scene, make, 300, every(7, 300), act);
    EXPECT_TRUE(beside);
}

// After a step that failed, the next one begins without impulses.
TEST(Snapshot, KnowsThatAStepFailed) {
    const Make make = [] { return scene_on_plane(); };
    auto scene = make();
    add_cube(*scene, 3);
    Workers workers(1);
    run(*scene, 5, 2, workers);
    const BodyState good = scene->state(26);
    BodyState fast = good;
    fast.linear_velocity_m_s.z = 1e5;
    need(scene->set_state(26, fast));
    ASSERT_FALSE(scene->step(kTick, 2, workers));
    need(scene->set_state(26, good));
    auto loaded = saved_and_loaded(*scene, make, workers);
    for (Scene* each : {scene.get(), loaded.get()}) run(*each, 3, 2, workers);
    EXPECT_EQ(loaded->digest(), scene->digest());
}

TEST(Snapshot, RefusesWhatCannotBe) {
    const Make make = [] { return scene_on_plane(); };
    auto scene = make();
    add_cube(*scene, 3);
    Workers workers(1);
    run(*scene, 3, 2, workers);
    ByteWriter rest, bodies;
    scene->save_rest(rest);
    scene->save_home(scene->home(0), {}, bodies);
    ByteReader in(bodies.view(), "the home");
    const SavedHome saved = SavedHome::read(in);
    const auto load = [&](const SavedHome& home) {
        auto other = make();
        ByteReader from_rest(rest.view(), "the rest");
        other->load_rest(from_rest);
        if (auto done = other->load_home(home, Holds::Own); !done) return done;
        return other->loaded(workers);
    };
    need(load(saved));
    for (std::size_t size = 0; size < saved.bodies.size(); size += 7) {
        const auto refused = load({saved.home, saved.bodies.first(size), saved.contacts});
        ASSERT_FALSE(refused) << size;
        EXPECT_TRUE(refused.error().problem.starts_with("the bodies of a snapshot ends too early")) << refused.error().problem;
    }
    for (std::size_t size = 1; size < saved.contacts.size(); size += 7)
        EXPECT_FALSE(load({saved.home, saved.bodies, saved.contacts.first(size)})) << size;
    auto twice = make();
    ByteReader again(rest.view(), "the rest");
    twice->load_rest(again);
    need(twice->load_home(saved, Holds::Own));
    EXPECT_FALSE(twice->load_home(saved, Holds::Own));
}

TEST(Snapshot, RefusesTouchesOfUnknownBodies) {
    const Make make = [] { return scene_on_plane({.engine = EngineKind::Hash}); };
    auto scene = make();
    add_cube(*scene, 1);
    ByteWriter bytes;
    scene->save_home(scene->home(0), {}, bytes);
    ByteReader in(bytes.view(), "the home");
    const SavedHome saved = SavedHome::read(in);
    for (const Touch touch : {Touch{0, 7, false}, Touch{7, 0, false}, Touch{0, 1, true}}) {
        ByteWriter contacts;
        contacts.write_count(1);
        contacts.write(touch);
        const auto loaded = make()->load_home({saved.home, saved.bodies, contacts.view()}, Holds::Own);
        ASSERT_FALSE(loaded);
        EXPECT_EQ(loaded.error().problem, "the snapshot of the bodies has invalid contacts");
    }
}

// Chains with motors, springs and limits, and a loop, in a pile; a joint ends with its body.
TEST(Snapshot, KnowsJoints) {
    const Make make = [] { return scene_on_plane(); };
    auto scene = make();
    BodyId id = 0;
    for (int c = 0; c < 12; ++c)
        for (int i = 0; i < 5; ++i, ++id) {
            const Vec3 at{1.0 * i + 0.1 * (c % 3), 1.2 * (c % 4), 1 + 1.1 * (c / 4)};
            need(scene->add_body({.id = id, .position_m = at}));
            if (i == 0) continue;
            JointSpec joint{.first = id - 1, .second = id, .anchor_m = at - Vec3{0.5, 0, 0}, .axis = {0, 1, 0}};
            joint.kind = c % 4 == 3 ? JointKind::Ball : JointKind::Hinge;
            if (c % 4 == 0) joint.strength = 20, joint.drive = {JointDrive::Kind::Servo, 0.5};
            if (c % 4 == 1) joint.stiffness = 10, joint.damping = 1;
            if (c % 4 == 2) joint.lower = -0.3, joint.upper = 0.3;
            need(scene->add_joint(joint));
        }
    need(scene->add_joint({.first = 0, .second = 20, .anchor_m = {0, 0, 1.5}, .axis = {0, 1, 0}}));
    const auto act = [](Scene& one, int tick) {
        if (tick == 30) need(one.drive_joint(1, 2, {JointDrive::Kind::Motor, 3}));
        if (tick == 40) need(one.drive_joint(1, 2, {JointDrive::Kind::Brake, 0}));
        if (tick == 50) need(one.remove_body(12));
    };
    follow(*scene, make, 90, {0, 1, 7, 29, 30, 31, 41, 49, 52, 70}, act);
}

}  // namespace
}  // namespace meld::physics
