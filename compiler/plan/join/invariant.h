// Terms that have the same value as often as they are computed.
#pragma once

#include "compiler/check/program/program.h"
#include "compiler/plan/join/draws.h"

namespace meld::plan {

// Whether a term has one value as long as its variables keep theirs, which `stays(variable)` tells. What functions outside the program
// return may differ from call to call.
template <class Stays>
bool is_invariant(const check::Program& program, const check::Term& term, const Stays& stays) {
    using check::Op;
    return !draws(program, term) && check::all_subterms(term, [&](const check::Term& t) {
        const bool external = t.op == Op::Call && program.functions[t.function].external;
        return !external && t.op != Op::Let && (!t.is_variable() || stays(t.variable));
    });
}

}  // namespace meld::plan
