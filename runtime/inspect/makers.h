// Where facts come from that no view derives: linear facts, and those that linear rules leave behind. Nothing of it is stored, so the run
// is made again.
#pragma once

#include <string>
#include <vector>

#include "runtime/inspect/explanation.h"
#include "runtime/timeline/timeline.h"

namespace meld::inspect {

// Adds the tick in which each fact that was made has appeared for the last time, and the linear rules that may have made it there, by the
// facts that there were in the tick before. Every process calls it; process 0 has the explanation. Errors: those of the timeline; a
// signal has asked for the end. Cost: the run once more, to the present tick, if anything was made.
Result<void> find_makers(timeline::Timeline& timeline, Explanation& explanation);

// The ticks in which facts that match one with _ or variables came and went.
struct Comings {
    struct Tick {
        std::int64_t tick = 0;
        std::vector<std::string> came = {}, went = {};
    };
    std::string asked = {};
    std::int64_t first_tick = 0, last_tick = 0;
    std::vector<std::string> at_first = {};  // Those that were there when the history begins.
    std::vector<Tick> ticks = {};
};

// From the first tick to the present one; on process 0. Every process calls it. Errors: as of find_makers(), and mistakes in `fact`. Cost:
// the run once more, and a search for each tick.
Result<Comings> history(timeline::Timeline& timeline, const std::string& fact);

}  // namespace meld::inspect
