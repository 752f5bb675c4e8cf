// What a line of a session can go on with: commands, predicates, rules and catoms, options and files, as the command says that it is
// written.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/ask/debug/line_editor.h"

namespace meld::debug {

// The names that there are in a run.
struct Vocabulary {
    std::vector<std::string> predicates = {};
    std::vector<std::string> rules = {};  // By which breaks are set: gradient.meld:10, and heads.
    std::vector<std::string> lines = {};  // The same for those of the program's own file, by their lines: 10.
    std::vector<std::string> heads = {};  // Predicates that rules give facts of.
    // Catoms whose numbers begin with these digits: the first of them, without @.
    std::function<std::vector<std::string>(std::string_view digits)> catoms = {};
    std::string folder = {};  // Where paths begin; empty: where the process is.
};

// Of a line up to the cursor. Words are in order, each once.
Completion complete(std::string_view line, const Vocabulary& vocabulary);

// The first catoms in order whose numbers begin with these digits, of those for which `exists` says so; all are below `next_id`.
std::vector<std::string> catoms_that_begin(std::string_view digits, std::uint64_t next_id,
                                           const std::function<bool(std::uint64_t)>& exists);

}  // namespace meld::debug
