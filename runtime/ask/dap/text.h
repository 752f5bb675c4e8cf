// Text between a client and the debugger: a client's may have any form, a command is a line.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/ask/dap/run.h"

namespace meld::dap {

// Longer lines are none that somebody types.
inline constexpr std::size_t kMaxLine_bytes = std::size_t{1} << 15;

// As Run::ask(), of a text that may have several lines, which become one. Errors: also that it is too long, or empty.
Result<Json> ask_line(Run& run, std::string_view text);

// The first word of a command; empty if there is none.
std::string_view first_word(std::string_view line);

// The values in "A = @3, L = [1, 2]", by name.
using Values = std::vector<std::pair<std::string, std::string>>;
Values bindings_in(std::string_view way);

// The text with the values in place of the variables.
std::string with_values(std::string_view text, const Values& values);

// The head of a view, and the facts that its body asks for, without those of negations and the like. Nothing if it is a linear rule.
std::string_view head_of(std::string_view rule);
std::vector<std::string> atoms_of(std::string_view rule);

// The word, as predicates are named, that ends at this place of a text.
std::string_view word_before(std::string_view text, std::size_t place);

// Where a column, in units of UTF-16, is in bytes.
std::size_t byte_offset(std::string_view text, std::size_t units);

// The catom in "@42", as its digits; empty if it is something else.
std::string_view catom_in(std::string_view text);

}  // namespace meld::dap
