// The file of a study: which runs a sweep consists of, what is measured in each, and what each must fulfil.
#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/error.h"

namespace meld::driver {

struct StudyProgram {
    std::string name;  // In tables: that of a variant, or the path as it is written.
    std::string path;
};

// A world as a file, or as a table of the study; with neither, each program has its own.
struct StudyWorld {
    std::string name;
    std::string path = {};
    const toml::table* keys = nullptr;
};

// A value of a parameter, in its three forms.
struct StudyValue {
    std::string literal;               // In Meld, for a constant.
    std::string plain;                 // In tables, and in strings of a world.
    const toml::node* node = nullptr;  // For a key of a world.
};

// A parameter with all its values.
struct StudyAxis {
    std::string name;
    std::vector<StudyValue> values;
    std::string place;
};

// A number of each run: a count of its summary, or the value of a body.
struct StudyMeasure {
    std::string name;
    std::string text;                      // As it is written.
    std::string body = {};                 // In Meld; empty: a count.
    std::vector<std::int64_t> ticks = {};  // After which it is measured; none: at the end.
    std::string place = {};
};

// What a run must fulfil, as by --expect and --never.
struct StudyDemand {
    std::string name;
    std::string text;  // As it is written.
    std::string body;
    bool never = false;
    std::string place = {};
};

struct Study {
    std::string path;
    std::string folder;  // Where paths in it begin: empty, or with a slash at its end.
    std::string text;
    std::shared_ptr<const toml::table> table;  // That worlds and values point into.
    std::vector<StudyProgram> programs;
    std::vector<StudyWorld> worlds;
    std::vector<std::uint64_t> seeds;  // None: the world's.
    std::vector<StudyAxis> axes;       // In the order of the file.
    std::vector<StudyMeasure> measures;
    std::vector<StudyDemand> demands;
    std::optional<std::int64_t> ticks = {};
    std::string until = {};
    double timeout_seconds = 0;
    int threads = 1;
    std::vector<std::string> events = {}, library = {}, link = {}, extensions = {};  // Paths.
};

// The keys of a table in the order of the file; the library sorts them.
std::vector<std::pair<std::string, const toml::node*>> in_order(const toml::table& table);

// Reads and checks a study. Errors name file, line and column, and the nearest key.
Result<Study> read_study(const std::string& path);

}  // namespace meld::driver
