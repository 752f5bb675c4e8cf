// `meldsim grade`: the submissions of students to an exercise.
#pragma once

#include "runtime/driver/grade/grade_options.h"

namespace CLI {
class App;
}

namespace meld::driver {

CLI::App* add_grade(CLI::App& app, GradeOptions& grade);

// Returns the exit code; prints its own messages.
int grade_command(const GradeOptions& options);

}  // namespace meld::driver
