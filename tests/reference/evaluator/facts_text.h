// Facts and values as answers write them, read back.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "tests/reference/evaluator/value.h"

namespace meld::reference {

// A fact of which some arguments may be open, written as _. The catom first.
struct Pattern {
    PredicateId predicate;
    std::vector<std::optional<Value>> arguments;

    bool whole() const;
    bool fits(const Row& row) const;
    // Of a whole one.
    Row row() const;
};

// Nothing: it is not a value of this type.
std::optional<Value> parse_value(const check::Type& type, std::string_view text);

// A fact of the program, also stable(p(@3, 1), 5). Nothing: it is none, or more comes after it.
std::optional<Pattern> parse_fact(const Program& program, std::string_view text);
// The same at the beginning of a text, of which it is then taken away.
std::optional<Pattern> take_fact(const Program& program, std::string_view& text);

// The number that stands behind the first of these words in a text.
std::optional<std::int64_t> number_after(std::string_view text, std::string_view words);

}  // namespace meld::reference
