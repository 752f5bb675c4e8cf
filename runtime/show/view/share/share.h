// A run as one page that needs no server: the viewer with the frames of some ticks and the facts of some predicates in it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/results/record/drawing.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/show/picture/frame.h"
#include "runtime/world/description/world.h"

namespace meld::view {

struct ShareOptions {
    std::string file = {};   // "-" is standard output.
    std::string title = {};  // What was run, for people.
    picture::Look look = {};
    std::vector<std::string> facts = {};  // Predicates; "all": those of the program.
    std::int64_t last = -1;               // The last tick; -1: that of the run.
    std::int64_t every = 1;               // Ticks between two frames.
    std::uint64_t most_bytes = 64'000'000;
};

struct Shared {
    std::uint64_t frames = 0, catoms = 0;  // The most catoms that there were.
    std::int64_t first = 0, last = 0;
    std::uint64_t bytes = 0;
};

// Goes on with the run from where it is, to the last tick, and writes the page. `drawing` gives that of the timeline's present run.
// `frame_made` is called after each frame. Every process calls it; process 0 writes, and has the result. Errors: mistakes in a body; no
// such predicate; the page would be too large; the run fails or is interrupted; those of the file. Cost: the run; of each frame that of
// looking at all catoms and at all facts of the predicates, and of compressing what has changed. Memory: some 100 bytes a catom, and the
// page.
Result<Shared> write_share(timeline::Timeline& timeline, const world::World& world, const std::function<record::Drawing&()>& drawing,
                           const ShareOptions& options, const std::function<void(std::int64_t tick)>& frame_made = {});

}  // namespace meld::view
