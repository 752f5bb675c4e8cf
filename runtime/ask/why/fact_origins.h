// Where facts come from that no view derives: linear facts, and those that linear rules leave behind. Nothing of it is stored, so the run
// is made again.
#pragma once

#include <string>
#include <vector>

#include "runtime/ask/why/explanation.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::inspect {

// Adds the tick in which each fact that was made has appeared for the last time, and the linear rules that may have made it there, by the
// facts that there were in the tick before. Every process calls it; process 0 has the explanation. Errors: those of the timeline; a
// signal has asked for the end. Cost: the run once more, to the present tick, if anything was made.
Result<void> find_origins(timeline::Timeline& timeline, Explanation& explanation);

}  // namespace meld::inspect
