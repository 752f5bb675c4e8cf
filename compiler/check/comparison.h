// The negation and the reversal of comparisons.
#pragma once

#include "compiler/check/program.h"

namespace meld::check {

inline bool compares(const Term& t) { return t.op >= Op::Equal && t.op <= Op::GreaterEqual; }

// True exactly when the comparison is false, except for NaN.
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

// The comparison with its sides exchanged; any other operator is unchanged.
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
