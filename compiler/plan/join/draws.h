// Whether an expression has another value when it is computed again: it draws a number, an id or a node.
#pragma once

#include "compiler/check/program/library.h"
#include "compiler/check/program/program.h"

namespace meld::plan {

inline bool draws(const check::Program& program, const check::Term& term) {
    bool found = check::is_random(program, term);
    check::each_subterm(term, [&](const check::Term& t) {
        found = found || t.op == check::Op::Fresh || t.op == check::Op::NewNode || t.op == check::Op::Due;
    });
    return found;
}

}  // namespace meld::plan
