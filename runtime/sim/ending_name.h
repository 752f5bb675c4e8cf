// How a run ends, as a word for programs: the same in summaries, answers of the debugger and messages to pages.
#pragma once

#include "runtime/sim/simulation.h"

namespace meld::sim {

inline const char* name_of(Ending ending) {
    switch (ending) {
        case Ending::Quiet:
            return "quiet";
        case Ending::Ticks:
            return "ticks";
        case Ending::Finished:
            return "finished";
        case Ending::Watched:
            return "watched";
        case Ending::Interrupted:
            return "interrupted";
        case Ending::Failed:
            return "failed";
    }
    return "";
}

}  // namespace meld::sim
