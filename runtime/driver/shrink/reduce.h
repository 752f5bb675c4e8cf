// The smallest world that still fails: what is tried to be taken away, and in which order.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/shrink/failure.h"
#include "runtime/driver/shrink/small_world.h"
#include "runtime/driver/shrink/trials.h"

namespace meld::driver {

struct Reduced {
    SmallWorld world;
    // "nodes: 80 to 41", a line for each kind of thing that there is.
    std::vector<std::string> became;
    bool least = false;  // No single thing that is left can be taken away.
};

// `keys` are those of a world that fails, files named from the root, and events of other files among its own; `seed` is that of the run.
// Errors: the world cannot be read; those of trials.
Result<Reduced> reduce(const toml::table& keys, std::uint64_t seed, const Failure& failure, bool makes_nodes, Trials& trials);

}  // namespace meld::driver
