// Conditions of a body that cannot all be true.
#pragma once

#include <optional>
#include <vector>

#include "compiler/check/program/program.h"

namespace meld::lint {

using check::Clause;
using check::Program;
using check::Rule;
using check::Term;

struct Condition {
    const Term* term = nullptr;
    bool holds = true;  // Otherwise it is known to be false.
};

struct Contradiction {
    Condition test;                      // It is never true ...
    std::vector<const Term*> with = {};  // ... together with these, in the order of the text; empty if it is false by itself.
};

// The parts of a condition, `A && B` as two, and the conditions among clauses.
std::vector<Condition> conditions(const Term& term);
std::vector<Condition> conditions(const std::vector<Clause>& body);

// The first of the conditions that cannot be true, by itself, together with others of them, or together with those that hold `around`: by
// the differences of ints, by the order of values, or by equality. Constants do not count as literals, because --set can change them.
// Assumes that the conditions around do not contradict each other.
std::optional<Contradiction> contradiction(const Program& program, const Rule& rule, const std::vector<Condition>& around,
                                           const std::vector<Condition>& body);

}  // namespace meld::lint
