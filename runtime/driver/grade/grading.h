// Grades all submissions of an exercise, several processes at a time. What is found out is kept in the folder of the results, so that the
// same command goes on where it was.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/grade/exercise_file.h"
#include "runtime/driver/grade/grade_options.h"
#include "runtime/driver/grade/submission.h"

namespace meld::driver {

// How a check went.
struct GradedCheck {
    bool fine = true;
    std::string found = {};  // What was found instead.
    std::string why = {};    // Why, if that is known.
    std::int64_t tick = -1;  // After which; -1: at no one tick.
};

// How a run went.
struct GradedRun {
    // "fine"; "wrong": a check failed; "error": of the program; "limit": of ticks, facts or derivations; "time", "memory", "output": those
    // of the exercise; "crash"; "": it was not run.
    std::string outcome = {};
    std::string reason = {};
    std::int64_t tick = 0;
    std::string said = {};
    std::vector<GradedCheck> checks = {};  // By check of the world; none: the run did not come to its end.
    std::string page = {};                 // The file of the world as a page, from the student's page; empty: there is none.
    double seconds = 0;
};

struct Grade {
    std::string problem = {};   // Why nothing was run; empty: it was.
    std::string messages = {};  // Of the compiler.
    std::uint64_t likeness = 0;
    std::vector<GradedRun> runs = {};            // By world.
    std::vector<std::size_t> same_as = {};       // Submissions with the same program but for names, comments, order and layout.
    bool as_solution = false, as_start = false;  // So is the solution, or the program that students begin with.
    std::uint64_t points = 0;
};

struct Grading {
    Exercise exercise;
    std::vector<Submission> submissions = {};
    std::vector<Grade> grades = {};  // By submission.
    std::string folder;              // Of the results.
    bool without_network = true;
    std::size_t made = 0, kept = 0;  // Runs made now, and before.
    bool interrupted = false;
};

// Errors: the folder cannot be written; no process can be started.
Result<void> grade_all(Grading& grading, const GradeOptions& options);

// The folder of a student's pages, from that of the results.
std::string student_folder(const Submission& submission);

}  // namespace meld::driver
