// What grading does with one submission, each in a confined process: its answers as JSON, which is also what is kept of them.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/driver/grade/exercise_file.h"
#include "runtime/driver/grade/submission.h"

namespace meld::driver {

// {"problem": why it is not graded, or ""; "messages": those of the compiler; "likeness"}. Compiles the program for all worlds.
std::string read_and_compile(const Exercise& exercise, const Submission& submission);

// {"outcome": "fine", "wrong", "limit" or "error"; "reason"; "tick": the last; "checks": of each, in order, {"name", "fine", "found",
// "tick": after which it was not as wanted, "why": if that is known}}.
std::string run_in_world(const Exercise& exercise, const Submission& submission, const ExerciseWorld& world);

// {"why": why a check fails after a tick: how far its body holds}. Makes the run again, to there.
std::string explain_check(const Exercise& exercise, const Submission& submission, const ExerciseWorld& world, std::size_t check,
                          std::int64_t tick);

// Becomes `meldsim view --share`, for the ticks up to this one. Returns only if that cannot be started.
std::string share_run(const Submission& submission, const Exercise& exercise, const ExerciseWorld& world, std::int64_t last_tick,
                      const std::string& file);

}  // namespace meld::driver
