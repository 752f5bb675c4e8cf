// How much memory a run will take, computed before anything is made: from the layouts of the program, the bricks of the world and what
// the run writes.
//
// How many facts catoms will have, and how many of them change in one tick, is known only when the program has run. So there is a least,
// which is certain, and a most, which assumes something about facts; where the two are near each other, this is an estimate.
#pragma once

#include <optional>
#include <vector>

#include "runtime/driver/setup/options.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/sim/catoms/brick_counts.h"
#include "runtime/world/description/world.h"

namespace meld::driver {

struct ByteRange {
    double least = 0, most = 0;
};

struct MemoryPart {
    const char* what = "";
    ByteRange bytes = {};
    // It is there only for a while, and no other such part then is.
    bool passing = false;
};

// Of the process that needs most.
struct MemoryNeed {
    double catoms = 0;      // Of all processes.
    double own_catoms = 0;  // Of this one.
    double base = 0;        // What the process takes before anything is made of the world.
    double start = 0;       // What it took for a moment when it started.
    std::vector<MemoryPart> parts = {};

    // What is made of the world.
    ByteRange made() const;
    // All that the process has at once.
    ByteRange peak() const;
};

// What `most` assumes, as a message says it.
inline constexpr const char* kMemoryAssumed =
    "that catoms have one fact of a predicate, or one for each neighbour if an argument is a catom (for each catom where there are at most "
    "100), "
    "that all may change and be sent in the same tick, and that lists are short";

// Processes share a world, whose catoms have been counted by sim::count_beforehand(); the first of them writes the files.
MemoryNeed memory_need(const world::World& world, const ModuleInfo& module, const RunOptions& options, int processes,
                       const std::optional<sim::BrickCounts>& counts);

}  // namespace meld::driver
