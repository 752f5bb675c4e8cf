// An ensemble divided at random, for tests of runs that are divided anew: some processes may get nothing.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "runtime/base/random.h"
#include "runtime/world/lattice/lattice.h"
#include "runtime/world/partition/partition.h"

namespace meld {

// Bricks within two of the origin weigh as `seed` says, so that most of these own nothing of a small world and some a part of it.
inline partition::Partition random_division(const world::Lattice& lattice, int processes, std::uint64_t seed) {
    std::vector<std::pair<world::BrickKey, std::uint32_t>> weights;
    const int flat = lattice.flat() ? 0 : 2;
    for (int z = -flat; z <= flat; ++z)
        for (int y = -2; y <= 2; ++y)
            for (int x = -2; x <= 2; ++x) {
                const world::BrickKey key = lattice.brick_key({x, y, z});
                weights.emplace_back(key, static_cast<std::uint32_t>(random_bits(seed, 0x64697669, key, 0) % 1000));
            }
    std::sort(weights.begin(), weights.end());
    return {weights, processes};
}

}  // namespace meld
