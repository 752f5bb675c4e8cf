// What operators make of known numbers, before the run as in it (runtime/module/kernel/values.h): for the values of constants and for the
// planner's pass `fold`. Questions compute with the kernel's own functions, and compare as here.
#pragma once

#include <cstdint>
#include <optional>

#include "compiler/check/program/term.h"

namespace meld::check {

// No value: the operator has none for these operands, and `problem` says why; without a problem it is no operator of such numbers.
template <class Number>
struct Computed {
    std::optional<Number> value = {};
    const char* problem = nullptr;
};
// An operator of one operand ignores `b`.
Computed<std::int64_t> compute(Op op, std::int64_t a, std::int64_t b);
Computed<double> compute(Op op, double a, double b);

// Whether a comparison holds.
template <class V>
bool holds(Op comparison, const V& a, const V& b) {
    switch (comparison) {
        case Op::Equal:
            return a == b;
        case Op::NotEqual:
            return a != b;
        case Op::Less:
            return a < b;
        case Op::LessEqual:
            return a <= b;
        case Op::Greater:
            return a > b;
        default:
            return a >= b;
    }
}

}  // namespace meld::check
