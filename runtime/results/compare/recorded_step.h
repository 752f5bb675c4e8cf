// One step of two recordings, catom by catom, once it is known to differ. Private to runtime/results/compare.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "runtime/results/compare/recorded_rows.h"
#include "runtime/results/compare/report.h"

namespace meld::compare {

// A series of the one recording and its like in the other.
struct SeriesPair {
    std::array<record::SeriesIndex, 2> in{};
    Renumbering renumbering = {};  // Of the second.
};

// What is compared in a step.
struct StepPairs {
    SeriesPair ids, points, line_ends;
    std::vector<SeriesPair> arrays;                                       // But for ids and points.
    std::vector<std::pair<std::string, std::vector<SeriesPair>>> tables;  // By name; the catom is first.
    std::vector<record::DescribedPredicate> predicates;                   // As both describe them.
};

// Fills in the report what differs in these steps: the least catom, all of it, and how many catoms differ. Errors: those of the readers.
Result<void> describe_step(std::array<record::RecordingReader*, 2> readers, std::array<std::size_t, 2> steps, const StepPairs& pairs,
                           Report& report);

}  // namespace meld::compare
