// `meldsim about`: what a run was, what made it, and the command that makes it again.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/setup/options.h"

namespace meld::driver {

struct AboutRun {
    std::string kind;  // "recording", "checkpoint" or "row".
    std::string name;
    // A file with the hash of its text.
    struct File {
        std::string path;
        std::uint64_t hash = 0;
    };
    std::vector<File> program = {};  // The main one first.
    std::vector<File> world = {};    // The world first, then what it names. None: the default world.
    std::vector<File> code = {};     // Extern functions and extensions.
    std::vector<std::string> set = {}, limits = {};
    std::optional<std::uint64_t> seed = {};
    nlohmann::ordered_json made_by = {};  // As of runtime/driver/setup/made_by.h; null: unknown.
    nlohmann::ordered_json counts = {};   // Of the summary, by name: the same on any machine; null: unknown.
    std::int64_t tick = 0;                // The last one,
    std::string digest = {};              // and the state after it; empty: unknown.
    std::optional<std::size_t> steps = {};
    std::vector<std::string> again = {};  // The command.
    std::string folder = {};              // Where it was typed; empty: unknown.
    std::vector<std::string> typed = {};  // The command that began the run.
    std::vector<std::string> lacks = {};  // What it does not contain, a clause each.
};

// Errors: it is damaged, or of another version.
Result<AboutRun> about_recording(const std::string& path);
// Its newest checkpoint. Errors: there is none.
Result<AboutRun> about_checkpoint(const std::string& folder, const ParseRun& parse);
// A row by its number, or the beginning of its key; results are in the folder, if that is not empty. Errors: there is no such row.
Result<AboutRun> about_row(const std::string& study, const std::string& row, const std::string& folder);

// The object that a text of a file is; null: it is none.
nlohmann::ordered_json object_in(const std::string& text);

// ---- forms
std::string about_text(const AboutRun& about);
std::string about_json(const AboutRun& about);
// A paragraph for a section on methods, with a table of counts.
std::string about_latex(const AboutRun& about);

}  // namespace meld::driver
