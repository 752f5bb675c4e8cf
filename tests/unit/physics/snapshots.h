// Scenes as they are saved, and loaded into others.
#pragma once

#include <cstddef>
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

}  // namespace meld::physics
