// A least or greatest value that a rule tests for exactly, and replaces by a value that follows from it.
#pragma once

#include <optional>
#include <vector>

#include "compiler/check/program/program.h"

namespace meld::lint {

using check::PredicateId;
using check::Program;
using check::Stratum;
using source::Span;

struct Replaced {
    PredicateId predicate;
    Span made;           // The better value, in a head.
    bool guard = false;  // A rule only tests whether the value that it derives is better than the existing one (guarded.h).
    Span asked;          // The test that the better value does not pass: the value in a fact of a body, or a condition.
    struct Between {
        PredicateId head, read;
        Span span;
    };
    std::vector<Between> between = {};  // The rules that lead from there to it.
};

// m(A, 4) :- m(A, 3), also through other predicates, for a max: the 3 is gone as soon as it has led to the 4, and the 4 with it. Only at
// one catom, in rules that test the stratum for nothing else, so that they certainly fire there. Constants count with their values.
std::optional<Replaced> replaced_by_itself(const Program& program, const check::Stratum& stratum);

}  // namespace meld::lint
