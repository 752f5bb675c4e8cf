// Whether an expression has another value when it is computed again: it draws a number, an id or a node.
#pragma once

#include "compiler/check/program/library.h"
#include "compiler/check/program/op_info.h"
#include "compiler/check/program/program.h"

namespace meld::plan {

inline bool draws(const check::Program& program, const check::Term& term) {
    return check::is_random(program, term) ||
           check::any_subterm(term, [](const check::Term& t) { return check::info(t.op).has(check::OpInfo::kDraws); });
}

}  // namespace meld::plan
