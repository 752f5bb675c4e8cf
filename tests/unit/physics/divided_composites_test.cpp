// Composites in a world divided among parts have the bits of the undivided world.
#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <random>

#include "tests/unit/physics/divided_world.h"

namespace meld::physics {
namespace {

// Composites of balls and of shapes, of two to sixty bodies: rods that reach over several blocks and hit each other, plates that bounce,
// one on a fixed body and one on a moving one, and a crowd among them. Some carry little.
void furnish_composites(Scene& scene, const std::function<bool(BodyId)>& mine) {
    const auto bouncy = need(scene.add_material({.friction = 0.4f, .restitution = 0.5f}));
    need(scene.add_obstacle(Plane{}, 0));
    need(scene.add_obstacle(Box{.centre = {6, 6, 1}, .size_m = {3, 2, 2}}, bouncy));
    const BodyShape cube = box_shape({0.8, 0.8, 0.8}, 0.02), rod = capsule_shape(0.3, 1.4);
    const auto add = [&](const BodySpec& spec) {
        if (!mine(spec.id)) return;
        need(scene.add_body(spec));
        if (spec.id % 3 == 0) need(scene.set_breaking(spec.id, {.force_n = 60 + 0.5 * spec.id, .torque_nm = 90}));
    };
    BodyId id = 0;
    for (int c = 0; c < 7; ++c)
        for (int i = 0; i < 4 + 8 * c; ++i, ++id) {
            const Vec3 at{c % 2 == 0 ? 1.0 * i - 12 : 2.5 * c - 6, c % 2 == 0 ? 2.0 * c : 1.0 * i - 9, 2.5 + 1.3 * c};
            BodySpec spec{.id = id, .position_m = at, .radius_m = 0.45, .material = static_cast<std::uint8_t>(c % 3 == 1 ? bouncy : 0)};
            if (c == 1) spec.shape = cube;
            if (c == 5 && i % 2 == 0) spec.shape = rod;
            if (c == 2) spec.fixed = i == 3;
            if (c == 4) spec.fixed = i == 0, spec.linear_velocity_m_s = {0, spec.fixed ? 0.4 : 0, 0};
            add(spec);
            if (i > 0) need(scene.connect(id - 1, id));
        }
    for (int i = 0; i < 25; ++i, ++id) {
        add({.id = id, .position_m = {8 + 1.0 * (i % 5), -8 + 1.0 * (i / 5), 3 + 0.3 * (i % 5)}, .material = bouncy});
        if (i % 5 > 0) need(scene.connect(id - 1, id));
        if (i >= 5) need(scene.connect(id - 5, id));
    }
    // Far from each other, and one.
    add({.id = id, .position_m = {-40, 0, 8}}), add({.id = id + 1, .position_m = {30, 1, 8}});
    need(scene.connect(id, id + 1));
    id += 2;
    // Two rods lie on the ground and sleep, over several blocks.
    for (int i = 0; i < 40; ++i, ++id) {
        add({.id = id, .position_m = {55 + 1.0 * (i % 20), -3.0 * (i / 20), 0.45}, .radius_m = 0.45});
        if (i % 20 > 0) need(scene.connect(id - 1, id));
    }
    std::mt19937 random(7);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2), speed(-3, 3);
    for (int i = 0; i < 200; ++i, ++id) {
        const Vec3 at{1.3 * (i % 10) - 6 + jitter(random), 1.3 * (i / 10 % 10) + jitter(random), 13 + 1.3 * (i / 100)};
        const Vec3 velocity{speed(random), speed(random), speed(random)};
        add({.id = id,
             .position_m = at,
             .linear_velocity_m_s = velocity,
             .radius_m = 0.4,
             .material = static_cast<std::uint8_t>(i % 2 == 0 ? bouncy : 0),
             .shape = i % 7 == 3 ? std::optional(cube) : std::nullopt});
    }
}

// What is made and broken while composites fall: in the tenth of ticks whose turn it is.
void change_connections(int tick, const std::function<void(const std::function<void(Scene&)>&)>& all) {
    if (tick % 10 != 5) return;
    const auto step = static_cast<BodyId>(tick);
    const auto gone = [&](BodyId id) { return id % 20 == 5 && id < step; };
    all([&](Scene& scene) {
        for (BodyId id = step % 7 + 1; id < 200; id += 13)
            if (!gone(id - 1) && !gone(id)) need(scene.release(id - 1, id));
        for (BodyId id = 30 + step % 11; id < 190; id += 37)
            if (!gone(id) && !gone(190 - id / 2)) need(scene.connect(id, 190 - id / 2));
        if (step % 4 == 1 && scene.has(step)) need(scene.remove_body(step));
        if (step % 4 == 1) scene.release_all(step);
    });
}

// They merge and split, carry loads, break, bounce and sleep.
TEST(Parts, GiveTheBitsOfTheUndividedWorldWithComposites) {
    const int ticks = 260;
    auto scene = make_scene(settings_for_shapes());
    furnish_composites(*scene, [](BodyId) { return true; });
    Workers workers(1);
    const auto halves = [](BlockCoordinates c) { return c.x < 0 ? 0 : 1; };
    const auto scattered = [](BlockCoordinates c) { return static_cast<int>(mix64(pack(c)) % 3); };
    const auto one_has_all = [](BlockCoordinates) { return 1; };
    std::vector<std::unique_ptr<Divided>> all;
    for (const auto& [parts, owner] :
         {std::pair<int, Subdomain::OwnerOf>{1, [](BlockCoordinates) { return 0; }}, {2, halves}, {3, scattered}, {2, one_has_all}})
        all.push_back(std::make_unique<Divided>(parts, owner, furnish_composites, settings_for_shapes()));
    scene->want_loads();
    for (const auto& divided : all) divided->change([](Scene& part) { part.want_loads(); });
    std::size_t slept = 0, broke = 0, kept = 0;
    for (int tick = 0; tick < ticks; ++tick) {
        change_connections(tick, [&](const auto& what) { what(*scene); });
        run(*scene, 1, 2, workers);
        slept += scene->awake_bodies() < scene->body_count() ? 1 : 0;
        std::optional<std::vector<ConnectionPair>> broken;
        std::map<ConnectionPair, ConnectionLoad> loads;
        // Loads are means over one tick or several.
        if (tick % 3 == 1) {
            broken = need(scene->solve_loads(workers));
            broke += broken->size();
            for (const auto& [pair, load] : scene->loads()) loads.emplace(pair, load);
        }
        for (const auto& divided : all) {
            change_connections(tick, [&](const auto& what) { divided->change(what); });
            divided->tick();
            ASSERT_EQ(divided->digest(), scene->digest()) << tick;
            if (!broken) continue;
            ASSERT_EQ(divided->break_connections(), *broken) << tick;
            const auto here = divided->loads();
            ASSERT_EQ(here.size(), loads.size()) << tick;
            for (const auto& [pair, load] : loads) {
                const auto at = here.find(pair);
                ASSERT_TRUE(at != here.end() && at->second == load) << tick << ": " << pair.first << " " << pair.second;
                ++kept;
            }
        }
    }
    EXPECT_GT(slept, 10u);
    EXPECT_GT(broke, 10u);
    EXPECT_GT(kept, 1000u);
    EXPECT_GT(all[2]->most_rounds, 1);
}

TEST(Parts, MayBeDividedAnewWithComposites) {
    expect_same_bits_divided_anew(
        furnish_composites, [](Scene& scene) { scene.want_loads(); },
        [](int tick, Divided& divided, Scene& scene, Workers& workers) {
            if (tick % 4 != 3) return;
            ASSERT_EQ(divided.break_connections(), need(scene.solve_loads(workers))) << tick;
            ASSERT_EQ(divided.loads().size(), scene.loads().size()) << tick;
        });
}

}  // namespace
}  // namespace meld::physics
