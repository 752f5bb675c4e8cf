// How much of a world a process will have: what Setup will make, counted before anything is made.
#pragma once

#include <optional>

#include "runtime/module/abi/module_abi.h"
#include "runtime/sim/catoms/brick_counts.h"
#include "runtime/world/description/world.h"

namespace meld::sim {

struct ExpectedShare {
    double catoms = 0;  // Its own.
    double ghosts = 0;
    double bricks = 0;       // With those around its own, where catoms look there.
    double with_catoms = 0;  // Those of its own that have catoms.
    bool exact = true;       // Otherwise of a world too large to be counted before every run.
};

// The share of the process that has the most catoms, and the catoms of all processes.
struct ExpectedShares {
    double catoms = 0;
    ExpectedShare largest = {};
};
// `counts`: of count_beforehand(). Cost: a look at the bricks around each.
ExpectedShares expected_shares(const world::World& world, const ModuleInfo& module, int processes,
                               const std::optional<BrickCounts>& counts);

}  // namespace meld::sim
