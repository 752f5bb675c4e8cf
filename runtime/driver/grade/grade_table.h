// The grades of an exercise as a table: for people, as CSV, and as JSON.
#pragma once

#include <string>

#include "runtime/driver/grade/grading.h"

namespace meld::driver {

// What is said of a submission beside its points: why it was not run, and which others are copies.
std::string remark(const Grading& grading, std::size_t submission);
// A run in a table: its outcome, or "-".
std::string outcome_word(const GradedRun& run);

// A line for each student, and below it what is to be said of them.
std::string grade_table(const Grading& grading);
std::string grade_csv(const Grading& grading);
// Of hidden worlds, what was found is part of it only if they are revealed.
std::string grade_json(const Grading& grading, bool reveal);

}  // namespace meld::driver
