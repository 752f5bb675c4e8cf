// Terms as sums: which of them name one value throughout a rule, which are literals, and what ints add up to.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "compiler/check/program.h"

namespace meld::lint {

using check::Program;
using check::Rule;
using check::Term;

// The value of a number, a catom or a truth value that stands there itself; of a text 0.
std::optional<double> literal(const Term& t);

// A name of the term without its conversion to float, where it has the same value wherever the rule has it; else empty.
std::string fixed_name(const Program& program, const Rule& rule, const Term& t);

// 2 * X - Y + 3: factors by the names of terms that are no sums themselves, and what is left.
struct LinearForm {
    std::map<std::string, std::int64_t> parts;
    std::int64_t rest = 0;
    // A multiple of one term, or of the difference of two.
    bool simple() const { return parts.size() < 2 || (parts.size() == 2 && parts.begin()->second == -parts.rbegin()->second); }
};
// Of an int; none where it has no name, or where numbers are too large to be added up safely.
std::optional<LinearForm> linear_form(const Program& program, const Rule& rule, const Term& t);
// Of a - b.
std::optional<LinearForm> linear_form(const Program& program, const Rule& rule, const Term& a, const Term& b);

}  // namespace meld::lint
