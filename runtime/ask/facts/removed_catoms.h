// Finds out when a catom was removed from a run, and why.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/base/error.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::inspect {

// The tick in which a catom was removed that does not exist at the timeline's tick, and the cause if it is known, in words: "it was killed
// in tick 7". Empty if there never was one, or if it was removed before the first tick of the timeline. Every process calls it, and gets
// the same. Errors: a state that cannot be made again; a signal has asked for the end. Cost: the logarithm of the number of ticks, each
// time a run to one of them.
Result<std::string> when_removed(timeline::Timeline& timeline, std::uint64_t catom);

}  // namespace meld::inspect
