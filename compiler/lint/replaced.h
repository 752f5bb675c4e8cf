// A least or greatest value that the program asks for exactly, and replaces by what follows from it.
#pragma once

#include <optional>
#include <vector>

#include "compiler/check/program.h"

namespace meld::lint {

using check::PredicateId;
using check::Program;
using check::Stratum;
using source::Span;

struct Replaced {
    PredicateId predicate;
    Span made;           // The better value, in a head.
    bool guard = false;  // The rule asks whether the value that it makes is better than the one that is there.
    Span asked;          // What it does not pass: the value in a fact of a body, or a condition.
    struct Between {
        PredicateId head, read;
        Span span;
    };
    std::vector<Between> between = {};  // The rules that lead from there to it.
};

// m(A, 4) :- m(A, 3), also by way of other predicates, for a max: the 3 is gone as soon as it has led to the 4, and the 4 with it.
// Only what happens at one catom, in rules that ask the stratum for nothing else, so that it is sure to where they fire.
// Constants count for what they are. Or a rule makes a value where it is better than that of the same group, with a min:
// v(A, Y) :- neighbor(A, B), v(A, X), v(B, Y), X > Y.
std::optional<Replaced> replaced_by_itself(const Program& program, const check::Stratum& stratum);

}  // namespace meld::lint
