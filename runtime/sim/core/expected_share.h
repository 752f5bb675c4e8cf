// How much of a world a process will have: what Setup will make, counted before anything is made.
#pragma once

#include <cstddef>

#include "runtime/abi/module_abi.h"
#include "runtime/base/error.h"
#include "runtime/world/world_file.h"

namespace meld::sim {

struct ExpectedShare {
    double catoms = 0;  // Its own.
    double ghosts = 0;
    double bricks = 0;       // With those around its own, where catoms look there.
    double with_catoms = 0;  // Those of its own that have catoms.
    bool exact = true;       // Otherwise of a world too large to be counted before every run.
};

// The share of the process that has the most catoms, and the catoms of all processes. Cost: as for world::count_bricks.
struct ExpectedShares {
    double catoms = 0;
    ExpectedShare largest = {};
};
Result<ExpectedShares> expected_shares(const world::World& world, const ModuleInfo& module, int processes);

}  // namespace meld::sim
