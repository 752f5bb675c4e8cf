// Terms that have the same value as often as they are computed.
#pragma once

#include "compiler/check/program/library.h"
#include "compiler/check/program/program.h"

namespace meld::plan {

// Whether a term has one value as long as its variables keep theirs, which `stays(variable)` tells. What functions outside the program
// return may differ from call to call.
template <class Stays>
bool is_invariant(const check::Program& program, const check::Term& term, const Stays& stays) {
    bool same = !is_random(program, term);
    check::each_subterm(term, [&](const check::Term& t) {
        using check::Op;
        const bool external = t.op == Op::Call && program.functions[t.function].external;
        same = same && !external && (!t.is_variable() || stays(t.variable)) && t.op != Op::Let && t.op != Op::Fresh &&
               t.op != Op::NewNode && t.op != Op::Due;
    });
    return same;
}

}  // namespace meld::plan
