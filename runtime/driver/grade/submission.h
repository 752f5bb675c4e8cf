// What students have handed in: a file or a folder each. Whatever it is, it is taken as data, and a mistake in it is that student's.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/grade/exercise_file.h"

namespace meld::driver {

struct Submission {
    std::string name;          // That of the file or folder, without .meld.
    std::string file;          // The same, as a name of files: letters, digits, '.', '-' and '_'; no two are the same.
    std::string problem = {};  // Why it cannot be graded; empty: it can.
    std::string program = {};  // The file to be compiled, from the folder of the submission.
    std::vector<std::pair<std::string, std::string>> files = {};  // By path from there: the text.
    std::uint64_t hash = 0;                                       // Of these.
};

// All of them, in the order of their names; names that begin with a dot are none. A single file is one. Links are not followed, and pipes
// and devices not opened. Errors: there is no such folder, it cannot be read, or it is empty.
Result<std::vector<Submission>> read_submissions(const std::string& path, const Exercise& exercise);

// A submission's program as it is read, in the folder with its files.
struct Reading {
    std::string problem = {};    // It includes a file that is not part of the submission; empty: it does not.
    std::uint64_t likeness = 0;  // runtime/driver/grade/likeness.h; 0: it has syntax errors.
};
// Parses whatever the student has written: to be called where that may go wrong.
Reading read_program(const Submission& submission, const Exercise& exercise);

}  // namespace meld::driver
