// Numbers that colours stand for: every int and every float of the language, exactly.
#pragma once

#include <limits>
#include <string>

namespace meld::render {

using Number = long double;
static_assert(std::numeric_limits<Number>::digits >= 64, "an int has 64 bits, and differences of two must be exact");

// The shortest text that reads back the same; of whole numbers all digits.
std::string text_of(Number number, bool whole);

}  // namespace meld::render
