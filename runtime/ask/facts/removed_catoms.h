// Catoms that were there once.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/base/error.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::inspect {

// In which tick a catom went that is not there at the timeline's tick, and by what if that is known, in words: "it was killed in tick 7".
// Empty if there never was one, or if it went before what the timeline can see. Every process calls it, and gets the same. Errors: a state
// that cannot be made again; a signal has asked for the end. Cost: the logarithm of the number of ticks, each time a run to one of them.
Result<std::string> when_gone(timeline::Timeline& timeline, std::uint64_t catom);

}  // namespace meld::inspect
