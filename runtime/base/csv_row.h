// Lines of fields: CSV as RFC 4180 has it, and its relatives with other separators. A quoted field ends on its line.
#pragma once

#include <cstddef>
#include <list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"

namespace meld {

// The text without blanks, tabs and the rest of a line's end around it.
std::string_view trimmed(std::string_view text);

// Programs for tables begin a file with this mark.
std::string_view without_byte_order_mark(std::string_view text);

// A text as a field, in quotes where it would otherwise be read as something else.
std::string csv_field(std::string_view text);

class CsvRow {
  public:
    explicit CsvRow(char separator) : separator_(separator) {}  // A blank: any number of blanks and tabs.
    // The fields of a line, which live until the next one: without blanks around them and without their quotes; two quotes inside a quoted
    // field are one. Errors name path, line and column; fields() are then those before the mistake. Cost: linear.
    Result<std::span<const std::string_view>> split(std::string_view line, std::string_view path, std::size_t number);
    std::span<const std::string_view> fields() const { return fields_; }
    // Where the field begins in its line, from 1.
    std::size_t column(std::size_t field) const { return columns_[field]; }
    // What separates the fields of this line: a comma, a semicolon or a tab outside of quotes, otherwise blanks.
    static char separator_of(std::string_view line);

  private:
    struct Mistake {
        std::size_t at;  // In the line.
        std::string problem, cure;
    };
    // Takes the field that begins with the quote at `begin`, and returns where the next one begins.
    tl::expected<std::size_t, Mistake> quoted(std::string_view line, std::size_t begin);
    tl::expected<std::size_t, Mistake> plain(std::string_view line, std::size_t begin);
    tl::expected<void, Mistake> read(std::string_view line);

    char separator_;
    std::vector<std::string_view> fields_;
    std::vector<std::size_t> columns_;
    std::list<std::string> unquoted_;  // Fields with quotes inside.
};

}  // namespace meld
