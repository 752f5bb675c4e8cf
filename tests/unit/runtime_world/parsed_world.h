// World files as tests write them.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "runtime/world/file/world_file.h"

namespace meld::world {

inline World world_of(const std::string& text) {
    Result<World> world = parse_world(text, "w.toml");
    EXPECT_TRUE(world) << world.error().message();
    return world ? std::move(*world) : World{};
}

// "fine" if there is none.
inline std::string error_of(const std::string& text) {
    const Result<World> world = parse_world(text, "w.toml");
    return world ? "fine" : world.error().message();
}

}  // namespace meld::world
