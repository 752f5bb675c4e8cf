// What it takes to make the run of a recording again: kept in the recording as JSON, so that `meldsim replay` needs no other file but code,
// which is named by its hash.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/world/description/world.h"

namespace meld::record {

// A file of code: recordings are data, and whoever replays one must have it. An extern function's C file, or an extension.
struct CodeFile {
    std::string path;  // As given to the run.
    std::uint64_t hash = 0;
};

struct Provenance {
    struct Source {
        std::string path;  // From the folder of the program's own file, which comes first.
        std::string text;
    };
    std::string version;      // Of Claymeld.
    std::string forked_from;  // The folder of the checkpoint at which the run branched off, which is not carried; mostly empty.
    std::vector<Source> program;
    std::uint32_t programs = 1;          // How many of these are programs, which come first.
    std::vector<std::string> libraries;  // Folders, from that of the program's file.
    std::optional<int> optimisation;
    std::vector<CodeFile> linked, extensions;
    std::string world_path;
    std::string world;                       // Its text.
    world::WorldFiles world_files;           // What it names, by path.
    std::map<std::string, std::string> set;  // Values of constants and of @arg1 and so on, in all.
    std::vector<std::string> limits = {};    // As --limit has them.
    std::uint64_t seed = 0;
    std::string ports;  // Whose numbers ports have.
    bool strict = false;
};

std::string to_json(const Provenance& provenance);
// Errors: it is none.
Result<Provenance> provenance_from_json(const std::string& text);

}  // namespace meld::record
