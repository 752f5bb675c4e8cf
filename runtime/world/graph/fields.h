// Lines of fields, and columns whose type the fields decide.
#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/csv_row.h"
#include "runtime/base/error.h"
#include "runtime/world/graph/graph.h"

namespace meld::graph {

// Calls visit(line, number), which returns Result<void>, for each line that is neither empty nor begins with # or %.
template <class Visit>
Result<void> each_line(std::string_view text, const Visit& visit) {
    text = without_byte_order_mark(text);
    for (std::size_t number = 1; !text.empty(); ++number) {
        const std::size_t end = text.find('\n');
        std::string_view line = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
        const std::size_t begin = line.find_first_not_of(" \t");
        if (begin == std::string_view::npos || line[begin] == '#' || line[begin] == '%') continue;
        if (Result<void> done = visit(line, number); !done) return done;
    }
    return {};
}

template <class T>
bool parse_whole(std::string_view text, T& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

// A column that begins as whole numbers and becomes numbers or strings when a field is none. The texts of numbers are not kept, so what is
// read as a number first is written as one.
class ColumnReader {
  public:
    explicit ColumnReader(std::string name) : column_{.name = std::move(name)} {}
    void add(std::string_view field);
    Column take() { return std::move(column_); }

  private:
    Column column_;
};

}  // namespace meld::graph
