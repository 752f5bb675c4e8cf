// The ticks in which facts came and went, and what made them come and go.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/ask/why/explanation.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::inspect {

struct Comings {
    // Rules are the ways by which a fact may have come or gone: one where it is certain.
    struct Change {
        // Derived: by views, also as one of many that are combined. Made: by linear rules. Given, Sensed: from outside.
        // Replaced: by another value of its group. Lost: what it was derived from does not hold any more; the rules are those by which it
        // held. Consumed: by linear rules. Taken: from outside. Gone: with its
        // catom. Unknown: nothing that there was before the tick says it.
        enum class How { Derived, Made, Given, Sensed, Replaced, Lost, Consumed, Taken, Gone, Unknown } how = How::Unknown;
        bool came = true;
        std::string fact = {};
        std::string by = {};  // Of Replaced: the fact in its place.
        std::vector<Explanation::Way> rules = {};
        std::uint64_t more = 0;  // Rules and catoms that are counted only.
    };
    struct Tick {
        std::int64_t tick = 0;
        std::vector<Change> changes = {};  // First those that went. In natural order.
    };
    std::string asked = {};
    std::int64_t first_tick = 0, last_tick = 0;
    std::vector<std::string> at_first = {};  // Those that were there when the history begins.
    std::vector<Tick> ticks = {};

    // A line for each.
    std::string to_text() const;
    nlohmann::ordered_json to_json() const;
};

// Of facts that match one with _ or variables, from the first tick to the present one; on process 0. Every process calls it. Errors:
// mistakes in `fact`; those of the timeline; a signal has asked for the end. Cost: the run once more, and twice to the last change, which
// are three states in memory; one more of both for each further link over which a rule reads; a search for each tick, and for each change.
Result<Comings> history(timeline::Timeline& timeline, const std::string& fact);

}  // namespace meld::inspect
