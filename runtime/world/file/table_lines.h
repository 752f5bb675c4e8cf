// Text files with a row of numbers on each line: lists of cells and of positions.
#pragma once

#include <algorithm>
#include <string_view>

#include "runtime/base/error.h"

namespace meld::world {

inline std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    return first == std::string_view::npos ? text.substr(0, 0) : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// A first line of words names the columns; numbers may be written `nan` or `inf`, which the callers refuse.
inline bool names_columns(std::string_view line) {
    const char c = line[0] | 0x20;
    return c >= 'a' && c <= 'z' && !line.starts_with("nan") && !line.starts_with("inf");
}

// Calls `visit(line, number)`, which returns a Result<void>, for each line with numbers, counted from 1, and `visit_names` for a line of
// names before the first. Skips empty lines and lines that start with '#'. Ends with the first error.
template <class Visit, class VisitNames>
Result<void> each_row(std::string_view text, const Visit& visit, const VisitNames& visit_names) {
    bool first = true;
    for (std::size_t number = 1; !text.empty(); ++number) {
        const std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(line.size() + 1, text.size()));
        const std::string_view content = trimmed(line);
        if (content.empty() || content[0] == '#') continue;
        const bool header = first && names_columns(content);
        first = false;
        if (Result<void> done = header ? visit_names(line, number) : visit(line, number); !done) return done;
    }
    return {};
}

// The same, for files in which names have no meaning.
template <class Visit>
Result<void> each_row(std::string_view text, const Visit& visit) {
    return each_row(text, visit, [](std::string_view, std::size_t) { return Result<void>(); });
}

// Calls `visit(field, column)` for each text between the commas of a line; columns of text are counted from 1.
template <class Visit>
Result<void> each_field(std::string_view line, const Visit& visit) {
    for (std::size_t at = 0; at <= line.size();) {
        const std::size_t end = std::min(line.find(',', at), line.size());
        if (Result<void> done = visit(trimmed(line.substr(at, end - at)), at + 1); !done) return done;
        at = end + 1;
    }
    return {};
}

}  // namespace meld::world
