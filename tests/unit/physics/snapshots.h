// Scenes as they are saved, and loaded into others.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "runtime/base/bytes.h"
#include "tests/unit/physics/scenes.h"

namespace meld::physics {

struct SavedScene {
    std::vector<std::byte> rest, homes;
    bool operator==(const SavedScene&) const = default;
};

inline SavedScene saved(const Scene& scene) {
    std::map<Home, std::vector<BodyId>> homes;
    for (const BodyId body : scene.bodies()) homes[scene.home(body)].push_back(body);
    ByteWriter rest, bodies;
    scene.save_rest(rest);
    for (const auto& [home, ids] : homes) scene.save_home(home, ids, bodies);
    return {rest.take(), bodies.take()};
}

// Into a scene that has what is not saved: settings, obstacles, materials.
inline std::unique_ptr<Scene> loaded(const SavedScene& bytes, std::unique_ptr<Scene> scene, Workers& workers) {
    ByteReader rest(bytes.rest, "the rest");
    scene->load_rest(rest);
    EXPECT_TRUE(rest.done());
    for (ByteReader in(bytes.homes, "the homes"); !in.done();) need(scene->load_home(SavedHome::read(in), Holds::Own));
    need(scene->loaded(workers));
    return scene;
}

// The bodies of a scene move alike for 200 ticks with 1, 2 and 4 threads, and from a snapshot after the 121st of them on. `empty` makes the
// scene with what is not saved.
inline void expect_same_bits(const std::function<std::unique_ptr<Scene>()>& empty, const std::function<void(Scene&)>& add_bodies) {
    std::vector<Digest> one;
    for (const int threads : {1, 2, 4}) {
        auto scene = empty();
        add_bodies(*scene);
        Workers workers(threads);
        std::vector<Digest> digests;
        SavedScene middle;
        for (int tick = 0; tick < 200; ++tick) {
            run(*scene, 1, 2, workers);
            digests.push_back(scene->digest());
            if (tick == 120) middle = saved(*scene);
        }
        if (one.empty()) one = digests;
        EXPECT_EQ(digests, one) << threads;
        auto again = loaded(middle, empty(), workers);
        run(*again, 79, 2, workers);
        EXPECT_EQ(again->digest(), one.back());
    }
}

}  // namespace meld::physics
