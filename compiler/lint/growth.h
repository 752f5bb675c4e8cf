// Arguments that a recursion computes from themselves without end.
#pragma once

#include <vector>

#include "compiler/check/program/program.h"

namespace meld::lint {

using check::PredicateId;
using check::Program;
using check::Stratum;
using source::Span;

struct Growing {
    PredicateId predicate;
    std::size_t argument = 0;
    Span span;  // Of the argument in the head.
    enum class How { Number, Longer } how = How::Number;
};

// d(A, N + 1) :- d(A, N), or a list or string that each round makes longer: a new fact for every value, unless an aggregate keeps only the
// best. A condition ends it if it need not hold for the next value; so does a fact of another stratum, of which there are only so many.
std::vector<Growing> growing_arguments(const Program& program, const Stratum& stratum);

}  // namespace meld::lint
