// Conditions of a body that cannot all be true.
#pragma once

#include <optional>
#include <vector>

#include "compiler/check/program.h"

namespace meld::lint {

using check::Clause;
using check::Program;
using check::Rule;
using check::Term;

struct Condition {
    const Term* term = nullptr;
    bool holds = true;  // Else it is known not to.
};

struct Contradiction {
    Condition test;                      // Never so ...
    std::vector<const Term*> with = {};  // ... together with these, in the order of the text; none where it is so alone.
};

// A condition, `A && B` as two, and the conditions among clauses.
std::vector<Condition> conditions(const Term& term);
std::vector<Condition> conditions(const std::vector<Clause>& body);

// The first of the conditions that cannot be true, by itself, with others of them, or with those that hold `around`: by the
// differences of ints, by the order of all that has one, by what is equal. Constants are no literals, for --set gives them
// other values. Assumes that those around do not contradict each other.
std::optional<Contradiction> contradiction(const Program& program, const Rule& rule, const std::vector<Condition>& around,
                                           const std::vector<Condition>& body);

}  // namespace meld::lint
