// Text files with a row of numbers on each line: lists of cells and of positions.
#pragma once

#include <algorithm>
#include <string_view>

#include "runtime/base/csv_row.h"
#include "runtime/base/error.h"

namespace meld::world {

// A first line of words names the columns; numbers may be written `nan` or `inf`, which the callers refuse.
inline bool names_columns(std::string_view line) {
    if (line.starts_with('"')) line.remove_prefix(1);
    const char c = line.empty() ? ' ' : line[0] | 0x20;
    return c >= 'a' && c <= 'z' && !line.starts_with("nan") && !line.starts_with("inf");
}

// Calls `visit(row, number)`, which returns a Result<void>, with the fields of each line with numbers, counted from 1, and `visit_names`
// for a line of names before the first. Skips empty lines and lines that start with '#'. Ends with the first error; those of quotes name
// `path`, line and column.
template <class Visit, class VisitNames>
Result<void> each_row(std::string_view text, std::string_view path, const Visit& visit, const VisitNames& visit_names) {
    CsvRow row(',');
    bool first = true;
    text = without_byte_order_mark(text);
    for (std::size_t number = 1; !text.empty(); ++number) {
        const std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(line.size() + 1, text.size()));
        const std::string_view content = trimmed(line);
        if (content.empty() || content[0] == '#') continue;
        const bool header = first && names_columns(content);
        first = false;
        if (const auto fields = row.split(line, path, number); !fields) return tl::unexpected<Error>(fields.error());
        if (Result<void> done = header ? visit_names(row, number) : visit(row, number); !done) return done;
    }
    return {};
}

// The same, for files in which names have no meaning.
template <class Visit>
Result<void> each_row(std::string_view text, std::string_view path, const Visit& visit) {
    return each_row(text, path, visit, [](const CsvRow&, std::size_t) { return Result<void>(); });
}

}  // namespace meld::world
