// The texts that an editor shows: hovers, completions, outlines. All are plain data; server.cpp turns them into protocol messages.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
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
    // The range to replace: the part of a name before the cursor.
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

// A cure of a message, as changes of files by their paths; whoever included them sees the message.
struct Action {
    std::string title;
    Message message;
    // The first that the message offers.
    bool preferred = false;
    std::map<std::string, std::vector<std::pair<Range, std::string>>> edits = {};
};
// The cures of the messages that are shown in this range or touch it.
std::vector<Action> actions(const Analysis& analysis, Range range);

// Edits by path that rename the symbol at the position in all the given programs; the first is the program of the position.
struct Edit {
    std::string path;
    Range range;
    bool operator<(const Edit& other) const;
};
Result<std::vector<Edit>> rename(const std::vector<const Analysis*>& programs, Position position, const std::string& name);

}  // namespace meld::lsp
