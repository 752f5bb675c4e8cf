// Of `meldsim grade`.
#pragma once

#include <string>

namespace meld::driver {

struct GradeOptions {
    std::string exercise;     // A folder.
    std::string submissions;  // A folder, or one file.
    std::string folder = {};  // Of results; empty: beside the submissions, SUBMISSIONS.grades.
    int jobs = 0;             // Processes at a time; 0: as there are processors.
    bool reveal = false;      // Pages and tables say what hidden worlds are.
    bool again = false;       // What ended at a limit is run again.
    bool json = false;
    bool quiet = false;
};

}  // namespace meld::driver
