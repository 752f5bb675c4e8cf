// Composites that merge and split at random, and break: against sums over their members from scratch, with the same bits however they came
// about, and through snapshots.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "physics/bodies/simd.h"
#include "physics/solver/engine.h"
#include "tests/unit/physics/snapshots.h"

namespace meld::physics {
namespace {

using Edges = std::set<std::pair<BodyId, BodyId>>;

// Changes of a tick: connections between bodies that are near each other, and releases.
void change(Scene& scene, Edges& edges, BodyId bodies, std::mt19937& random, int changes) {
    for (int i = 0; i < changes; ++i) {
        const auto a = BodyId(random() % bodies);
        if (!scene.has(a)) continue;
        if (!edges.empty() && random() % 5 < 2) {
            const auto [one, other] = *std::next(edges.begin(), static_cast<long>(random() % edges.size()));
            need(scene.release(one, other));
            edges.erase({one, other});
            continue;
        }
        for (BodyId b = a + 1; b < bodies; ++b)
            if (scene.has(b) && length(scene.state(a).position_m - scene.state(b).position_m) < 1.25) {
                need(scene.connect(b, a));
                edges.insert({a, b});
                break;
            }
    }
}

std::map<BodyId, std::vector<BodyId>> groups_of(const Edges& edges) {
    std::map<BodyId, BodyId> label;
    for (const auto& [a, b] : edges) label[a] = a, label[b] = b;
    for (bool changed = true; changed;) {
        changed = false;
        for (const auto& [a, b] : edges)
            if (const BodyId least = std::min(label[a], label[b]); label[a] != least || label[b] != least)
                label[a] = label[b] = least, changed = true;
    }
    std::map<BodyId, std::vector<BodyId>> groups;
    for (const auto& [body, least] : label) groups[least].push_back(body);
    return groups;
}

// Each composite is what its members' masses, places and velocities say, and each member moves as its composite does.
void compare_with_sums(const Scene& scene, const Edges& edges, BodyId bodies, const std::map<BodyId, double>& masses) {
    std::set<BodyId> members;
    for (const auto& [least, group] : groups_of(edges)) {
        const auto composite = scene.composite(least);
        ASSERT_TRUE(composite) << least;
        ASSERT_EQ(composite->bodies, group.size()) << least;
        double mass = 0;
        Vec3 centre, momentum;
        for (const BodyId body : group) {
            members.insert(body);
            const double m = masses.at(body);
            mass += m, centre = centre + m * scene.state(body).position_m;
            momentum = momentum + m * scene.state(body).linear_velocity_m_s;
        }
        centre = (1 / mass) * centre;
        Vec3 angular;
        for (const BodyId body : group) {
            const BodyState state = scene.state(body);
            const Vec3 arm = state.position_m - centre;
            angular = angular + masses.at(body) * cross(arm, state.linear_velocity_m_s) +
                      scene.moment_of_inertia(body) * state.angular_velocity_rad_s;
            const Vec3 expected = composite->linear_velocity_m_s + cross(composite->angular_velocity_rad_s, arm);
            ASSERT_LT(length(state.linear_velocity_m_s - expected), 1e-5) << body;
            ASSERT_LT(length(state.angular_velocity_rad_s - composite->angular_velocity_rad_s), 1e-5) << body;
        }
        ASSERT_NEAR(composite->mass_kg, mass, 1e-6 * mass);
        ASSERT_LT(length(composite->centre_m - centre), 1e-9);
        ASSERT_LT(length(mass * composite->linear_velocity_m_s - momentum), 1e-5 * mass);
        ASSERT_LT(length(composite->inertia_kg_m2 * composite->angular_velocity_rad_s - angular), 1e-5 * (1 + length(angular)));
    }
    for (BodyId body = 0; body < bodies; ++body) ASSERT_FALSE(scene.has(body) && !members.contains(body) && scene.composite(body)) << body;
}

// Breaks what is overloaded; what is left is not, unless as much as is allowed at once has broken.
std::size_t break_overloaded(Scene& scene, Edges& edges, const std::map<BodyId, BreakingLimits>& limits, Workers& workers) {
    const std::vector<ConnectionPair> broken = need(scene.solve_loads(workers));
    for (const ConnectionPair& pair : broken) {
        EXPECT_EQ(edges.erase(pair), 1u);
        EXPECT_FALSE(scene.connected(pair.first, pair.second));
    }
    EXPECT_EQ(scene.loads().size(), edges.size());
    for (const CarriedLoad& each : scene.loads()) {
        EXPECT_TRUE(edges.contains(each.pair));
        for (const BodyId body : {each.pair.first, each.pair.second}) {
            if (!limits.contains(body) || broken.size() >= 16) continue;
            EXPECT_LE(each.load.tearing_n(), 1.00001 * limits.at(body).force_n);
            EXPECT_LE(each.load.torque_nm(), 1.00001 * limits.at(body).torque_nm);
        }
    }
    return broken.size();
}

TEST(CompositeChanges, AgreeWithSumsFromScratch) {
    for (const unsigned seed : {1u, 2u, 3u}) {
        Settings settings;
        if (seed != 3) settings.gravity_m_s2 = {};
        auto scene = seed == 3 ? scene_on_plane(settings) : make_scene(settings);
        std::mt19937 random(seed);
        const BodyId bodies = 216;
        add_cloud(*scene, 6, 1.02, seed);
        std::map<BodyId, double> masses;
        for (BodyId body = 0; body < bodies; ++body) masses[body] = double(float(8 * std::pow(scene->radius(body), 3)));
        // Some break.
        std::map<BodyId, BreakingLimits> limits;
        for (BodyId body = 0; body < bodies; body += 11) limits[body] = {.force_n = 4, .torque_nm = body % 2 == 0 ? 2.0 : 1000};
        for (const auto& [body, most] : limits) need(scene->set_breaking(body, most));
        Edges edges;
        std::size_t most = 0, broken = 0;
        Workers workers(1);
        for (int tick = 0; tick < 120; ++tick) {
            change(*scene, edges, bodies, random, int(random() % 12));
            if (tick % 30 == 29) {
                const auto gone = BodyId(random() % bodies);
                if (scene->has(gone)) need(scene->remove_body(gone));
                limits.erase(gone);
                std::erase_if(edges, [gone](const auto& edge) { return edge.first == gone || edge.second == gone; });
            }
            const Vec3 momentum = scene->momentum();
            const bool removed = tick % 30 == 29;
            run(*scene, 1, 2, workers);
            most = std::max(most, edges.size());
            compare_with_sums(*scene, edges, bodies, masses);
            if (HasFatalFailure()) return;
            EXPECT_TRUE(seed == 3 || removed || length(scene->momentum() - momentum) < 1e-3) << tick;
            broken += break_overloaded(*scene, edges, limits, workers);
        }
        EXPECT_GT(most, 50u);
        EXPECT_GT(broken, 3u);
    }
}

// The state after each tick, and what connections carried.
struct Crowd {
    std::vector<Digest> digests;
    std::vector<ConnectionLoad> loads;
    std::size_t broken = 0;
    bool operator==(const Crowd&) const = default;
};

// Everything at once: composites of all sizes among loose bodies, bouncing and not, on a plane and a box, with magnets and latches.
Crowd run_crowd(int threads, std::uint64_t save_at = 0, SolverMode mode = SolverMode::Soft) {
    Settings settings;
    if (mode == SolverMode::Pgs) settings.solver = SolverSettings::pgs20();
    const auto build = [&] {
        auto scene = scene_on_plane(settings);
        const auto bouncy = need(scene->add_material({.friction = 0.3f, .restitution = 0.4f}));
        need(scene->add_obstacle(Box{.centre = {4, 4, 0.8}, .size_m = {3, 2, 2}, .orientation = {std::cos(0.2), 0, 0, std::sin(0.2)}},
                                 bouncy));
        std::vector<Feature> features;
        for (const Vec3 direction : feature_directions(12))
            features.push_back({.direction = direction, .strength = 200, .depth_m = 0.05, .range_m = 0.2});
        features.push_back({.direction = {0, 0, 1}, .kind = FeatureKind::Latch, .strength = 50, .range_m = 0.3});
        need(scene->add_feature_table(features));
        scene->want_loads();
        return scene;
    };
    auto scene = build();
    const BodyId bodies = 1000;
    add_cloud(*scene, 10, 1.2, 23);
    for (BodyId id = 0; id < bodies; id += 2) {
        need(scene->set_feature_table(id, 1));
        need(scene->set_features(id, 0x1fff, id % 3 == 0 ? 0x555 : 0));
    }
    // A long beam over several blocks, and a post that a fixed ball holds.
    for (BodyId i = 0; i < 40; ++i) {
        need(scene->add_body({.id = 2000 + i, .position_m = {-10 + double(i), 6, 16}}));
        if (i > 0) need(scene->connect(1999 + i, 2000 + i));
    }
    for (BodyId i = 0; i < 5; ++i) {
        need(scene->add_body({.id = 3000 + i, .position_m = {-2, -2, 0.6 + double(i)}, .fixed = i == 0}));
        if (i > 0) need(scene->connect(2999 + i, 3000 + i));
    }
    for (BodyId id = 0; id < bodies; id += 3) need(scene->set_breaking(id, {.force_n = 20, .torque_nm = 5}));
    for (BodyId id = 2000; id < 2040; ++id) need(scene->set_breaking(id, {.torque_nm = 150}));
    Edges edges;
    std::mt19937 random(5);
    Workers workers(threads);
    Crowd crowd;
    for (std::uint64_t tick = 0; tick < 60; ++tick) {
        change(*scene, edges, bodies, random, 25);
        if (tick == 40) need(scene->remove_body(2020));
        run(*scene, 1, 2, workers);
        // Of every second tick, so that a snapshot also holds what has been added up since.
        if (tick % 2 == 1) {
            const std::vector<ConnectionPair> broken = need(scene->solve_loads(workers));
            for (const ConnectionPair& pair : broken) edges.erase(pair);
            crowd.broken += broken.size();
        }
        for (const CarriedLoad& each : scene->loads()) crowd.loads.push_back(each.load);
        crowd.digests.push_back(scene->digest());
        if (tick + 1 != save_at) continue;
        // Connections made after the step are saved too.
        need(scene->connect(2000, 2002));
        auto other = loaded(saved(*scene), build(), workers);
        EXPECT_EQ(other->digest(), scene->digest());
        EXPECT_TRUE(other->connected(2000, 2002));
        // It would carry a part of the loads.
        need(other->release(2000, 2002));
        scene = std::move(other);
    }
    return crowd;
}

TEST(CompositeChanges, SameBitsForAnyNumberOfWorkers) {
    for (const SolverMode mode : {SolverMode::Soft, SolverMode::Pgs}) {
        const Crowd one = run_crowd(1, 0, mode);
        EXPECT_NE(one.digests[10], one.digests[11]);
        EXPECT_GT(one.loads.size(), 1000u);
        EXPECT_GT(one.broken, 3u);
        EXPECT_EQ(run_crowd(2, 0, mode), one);
    }
}

TEST(CompositeChanges, SameBitsForAnyInstructionSet) {
    const SimdLevel best = simd_level();
    const Crowd one = run_crowd(1);
    set_simd_level(SimdLevel::Baseline);
    const Crowd baseline = run_crowd(1);
    set_simd_level(best);
    EXPECT_EQ(baseline, one);
}

TEST(CompositeChanges, SameBitsThroughASnapshot) {
    const Crowd one = run_crowd(1);
    for (const std::uint64_t tick : {1u, 17u, 41u}) EXPECT_EQ(run_crowd(2, tick), one) << tick;
}

TEST(CompositeChanges, SameBitsInAnyOrder) {
    // The same connections in another order, with others that come and go in between.
    const auto digests = [](unsigned order) {
        auto scene = scene_on_plane();
        add_cube(*scene, 6, 1, {0, 0, 0.7});
        for (BodyId body = 0; body < 216; body += 4) need(scene->set_breaking(body, {.torque_nm = 30}));
        Workers workers(1);
        std::vector<Digest> result;
        Edges edges;
        std::mt19937 random(11), shuffle(order);
        for (int tick = 0; tick < 40; ++tick) {
            std::vector<std::tuple<BodyId, BodyId, bool>> changes;
            for (int i = 0; i < 10; ++i) {
                const auto a = BodyId(random() % 215);
                const std::pair<BodyId, BodyId> edge{a, a + 1};
                if (const bool make = random() % 3 != 0; make != edges.contains(edge)) {
                    make ? (void)edges.insert(edge) : (void)edges.erase(edge);
                    changes.emplace_back(a, a + 1, make);
                }
            }
            // An edge may occur twice, and only its last change counts.
            if (order != 0) {
                std::map<std::pair<BodyId, BodyId>, bool> last;
                for (const auto& [a, b, make] : changes) last[{a, b}] = make;
                changes.clear();
                for (const auto& [edge, make] : last) changes.emplace_back(edge.first, edge.second, make);
                std::shuffle(changes.begin(), changes.end(), shuffle);
                for (BodyId a = 0; a < 180; a += 7)
                    if (!scene->connected(a, a + 36)) need(scene->connect(a, a + 36)), need(scene->release(a + 36, a));
            }
            for (const auto& [a, b, make] : changes) need(make ? scene->connect(a, b) : scene->release(b, a));
            run(*scene, 1, 2, workers);
            for (const ConnectionPair& pair : need(scene->solve_loads(workers))) edges.erase(pair);
            result.push_back(scene->digest());
        }
        return result;
    };
    const std::vector<Digest> one = digests(0);
    EXPECT_EQ(digests(1), one);
    EXPECT_EQ(digests(2), one);
}

}  // namespace
}  // namespace meld::physics
