// A page for each student, and one for the teacher with all of them.
#pragma once

#include <string>

#include "runtime/driver/grade/grading.h"

namespace meld::driver {

// What a student gets: points, how each world went, and why. Of hidden worlds only whether all was well, unless they are revealed; nothing
// of other students.
std::string student_page(const Grading& grading, std::size_t submission, bool reveal);
// The table, with links to the pages of students.
std::string overview_page(const Grading& grading);

}  // namespace meld::driver
