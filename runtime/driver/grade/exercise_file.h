// An exercise: a folder with a text for students, a program to begin with, worlds, and what must hold in each.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "runtime/base/error.h"

namespace meld::driver {

// What must hold in a world, as --expect and --never say it.
struct ExerciseCheck {
    std::string name;
    std::string text;  // As it is written.
    std::string body;
    bool never = false;
    std::vector<std::int64_t> ticks = {};  // After which it must hold; none: at the end.
};

struct ExerciseWorld {
    std::string name;
    std::string path;  // Absolute.
    bool hidden = false;
    std::uint64_t points = 1;
    std::optional<std::int64_t> ticks = {};  // The run ends there.
    std::optional<std::int64_t> seed = {};
    std::vector<ExerciseCheck> checks = {};
};

// Of each run, and of each compilation.
struct ExerciseLimits {
    double seconds = 10;  // Of processor time.
    double compile_seconds = 60;
    std::uint64_t memory = std::uint64_t{1} << 30;
    std::uint64_t output = 64 << 10;  // Bytes that a program may print.
    std::uint64_t ticks = 10'000;
};

struct Exercise {
    std::string folder;  // Absolute.
    std::string title;
    std::string program;                    // That students begin with: absolute.
    std::vector<std::string> library = {};  // Folders: absolute.
    ExerciseLimits limits = {};
    std::vector<ExerciseWorld> worlds = {};
    // Of everything that results depend on: all files but the text for students, solutions and wrong programs.
    std::uint64_t hash = 0;

    std::uint64_t points() const;
};

// Reads EXERCISE/exercise.toml and, if there is one, EXERCISE/hidden/hidden.toml. Errors name file, line and column, and the nearest key; a
// world or a program is missing.
Result<Exercise> read_exercise(const std::string& folder);

}  // namespace meld::driver
