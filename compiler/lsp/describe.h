// What an editor shows: hovers, completions, outlines. All as plain data; server.cpp makes protocol messages of them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/lsp/analysis.h"

namespace meld::lsp {

struct HoverText {
    std::string markdown;
    Range range;
};
std::optional<HoverText> hover(const Analysis& analysis, Position position);

struct Completion {
    enum class Kind { Predicate, Action, Constant, Function, Variable, Keyword } kind = Kind::Keyword;
    std::string name;
    std::string detail = {};
    std::string doc = {};
};
struct Completions {
    // What is replaced: the part of a name before the cursor.
    Range replaced;
    std::vector<Completion> list;
};
Completions complete(const Analysis& analysis, Position position);

struct Outline {
    enum class Kind { Predicate, Action, Constant, Function, Rule, File } kind = Kind::Rule;
    std::string name;
    std::string detail;
    Range range;
    Range name_range;
};
std::vector<Outline> outline(const Analysis& analysis);

// Edits by path that give the symbol at the position another name, in all the programs given; the first is the one of the position.
struct Edit {
    std::string path;
    Range range;
    bool operator<(const Edit& other) const;
};
Result<std::vector<Edit>> rename(const std::vector<const Analysis*>& programs, Position position, const std::string& name);

}  // namespace meld::lsp
