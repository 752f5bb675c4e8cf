// What depends on a fact: the run as it would be without it, beside the run as it is.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/ask/debug/answer.h"
#include "runtime/base/error.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/world/description/world.h"

namespace meld::debug {

// Both runs go on for so many ticks at most, if nothing else is said.
constexpr std::int64_t kDependsTicks = 10'000;

struct DependsAsked {
    std::string fact = {};  // In Meld, without variables.
    std::int64_t ticks = kDependsTicks;
    std::uint64_t most_lines = 0;  // Beyond these, facts are only counted.
};

// Takes the fact at the start of the next tick, in a run of its own, lets that and the run as it is go on until nothing is left to do, and
// compares what holds then. The timeline stays where it is, and its world is what it was when this returns. Every process calls it. Errors:
// mistakes in the fact; it does not hold, or is not given; a run fails; a signal has asked for the end. Cost: both runs, with their memory,
// and a look at all facts of both.
Result<Answer> depends(timeline::Timeline& timeline, world::World& world, const DependsAsked& asked);

}  // namespace meld::debug
