// The operators between two operands, as the table compiler/syntax/operators.def has them; the negation and the reversal of comparisons.
#pragma once

#include <string_view>

#include "compiler/check/program/program.h"
#include "compiler/syntax/tree.h"

namespace meld::check {

inline Op op_of(syntax::BinaryOp op) {
    static constexpr Op kOps[] = {
#define MELD_BINARY(name, spelling, level, groups) Op::name,
#include "compiler/syntax/operators.def"
    };
    return kOps[static_cast<std::size_t>(op)];
}

// "+", "<>", "&&"; empty for what is no operator between two operands.
inline std::string_view sign_of(Op op) {
    switch (op) {
#define MELD_BINARY(name, spelling, level, groups) \
    case Op::name:                                 \
        return spelling;
#include "compiler/syntax/operators.def"
        default:
            return {};
    }
}

inline bool is_comparison(Op op) { return op >= Op::Equal && op <= Op::GreaterEqual; }
inline bool compares(const Term& t) { return is_comparison(t.op); }

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
