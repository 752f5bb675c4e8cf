// What comparisons mean the other way round.
#pragma once

#include "compiler/check/program.h"

namespace meld::check {

inline bool compares(const Term& t) { return t.op >= Op::Equal && t.op <= Op::GreaterEqual; }

// True where the comparison is false, but for floats that are no number.
inline Op opposite(Op op) {
    switch (op) {
        case Op::Equal:
            return Op::NotEqual;
        case Op::NotEqual:
            return Op::Equal;
        case Op::Less:
            return Op::GreaterEqual;
        case Op::LessEqual:
            return Op::Greater;
        case Op::Greater:
            return Op::LessEqual;
        default:
            return Op::Less;
    }
}

// The same with its sides exchanged; any other operator stays.
inline Op turned(Op op) {
    switch (op) {
        case Op::Less:
            return Op::Greater;
        case Op::LessEqual:
            return Op::GreaterEqual;
        case Op::Greater:
            return Op::Less;
        case Op::GreaterEqual:
            return Op::LessEqual;
        default:
            return op;
    }
}

}  // namespace meld::check
