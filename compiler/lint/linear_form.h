// Terms as sums: which of them denote one value throughout a rule, which are literals, and the sums of ints.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "compiler/check/program/program.h"

namespace meld::lint {

using check::Program;
using check::Rule;
using check::Term;

// The value of a literal number, catom or bool; 0 for a string.
std::optional<double> literal(const Term& t);

// A name for the term without its conversion to float, if it has the same value wherever the rule uses it; otherwise empty.
std::string fixed_name(const Program& program, const Rule& rule, const Term& t);

// 2 * X - Y + 3: the factors, by the names of terms that are not sums themselves, and the constant.
struct LinearForm {
    std::map<std::string, std::int64_t> parts;
    std::int64_t rest = 0;
    // A multiple of one term, or of the difference of two.
    bool simple() const { return parts.size() < 2 || (parts.size() == 2 && parts.begin()->second == -parts.rbegin()->second); }
};
// For an int; none if it has no name, or if numbers are too large to be added safely.
std::optional<LinearForm> linear_form(const Program& program, const Rule& rule, const Term& t);
// Of a - b.
std::optional<LinearForm> linear_form(const Program& program, const Rule& rule, const Term& a, const Term& b);

}  // namespace meld::lint
