#include "compiler/check/program/arithmetic.h"

#include <algorithm>
#include <cmath>

namespace meld::check {

namespace {

constexpr const char* kDoesNotFit = "this does not fit into 64 bits";
constexpr const char* kDivisionByZero = "division by zero";

using Whole = Computed<std::int64_t>;

Whole fitting(bool overflow, std::int64_t value) { return overflow ? Whole{.problem = kDoesNotFit} : Whole{.value = value}; }

Whole negated(std::int64_t a) {
    std::int64_t out = 0;
    const bool overflow = __builtin_sub_overflow(std::int64_t{0}, a, &out);
    return fitting(overflow, out);
}

Whole divided(Op op, std::int64_t a, std::int64_t b) {
    if (b == 0) return {.problem = kDivisionByZero};
    // The least int has no quotient, but a remainder.
    if (b == -1) return op == Op::Divide ? negated(a) : Whole{.value = 0};
    return {.value = op == Op::Divide ? a / b : a % b};
}

Whole power(std::int64_t a, std::int64_t b) {
    if (b < 0) return {.problem = "a whole number has no whole power below 0"};
    if (a == 0 || a == 1 || a == -1) return {.value = b == 0 || a == 1 || (a == -1 && b % 2 == 0) ? 1 : a};
    std::int64_t out = 1;
    bool overflow = false;
    for (std::int64_t i = 0; i < b && !overflow; ++i) overflow = __builtin_mul_overflow(out, a, &out);
    return fitting(overflow, out);
}

}  // namespace

Computed<std::int64_t> compute(Op op, std::int64_t a, std::int64_t b) {
    std::int64_t out = 0;
    bool overflow = false;
    switch (op) {
        case Op::Add:
            overflow = __builtin_add_overflow(a, b, &out);
            return fitting(overflow, out);
        case Op::Subtract:
            overflow = __builtin_sub_overflow(a, b, &out);
            return fitting(overflow, out);
        case Op::Multiply:
            overflow = __builtin_mul_overflow(a, b, &out);
            return fitting(overflow, out);
        case Op::Divide:
        case Op::Modulo:
            return divided(op, a, b);
        case Op::Power:
            return power(a, b);
        case Op::Negate:
            return negated(a);
        case Op::Abs:
            return a < 0 ? negated(a) : Whole{.value = a};
        case Op::Min:
            return {.value = std::min(a, b)};
        case Op::Max:
            return {.value = std::max(a, b)};
        default:
            return {};
    }
}

Computed<double> compute(Op op, double a, double b) {
    double out = 0;
    switch (op) {
        case Op::Add:
            out = a + b;
            break;
        case Op::Subtract:
            out = a - b;
            break;
        case Op::Multiply:
            out = a * b;
            break;
        case Op::Divide:
        case Op::Modulo:
            if (b == 0) return {.problem = kDivisionByZero};
            out = op == Op::Divide ? a / b : std::fmod(a, b);
            break;
        case Op::Power:
            out = std::pow(a, b);
            break;
        case Op::Negate:
            out = -a;
            break;
        case Op::Abs:
            out = std::fabs(a);
            break;
        case Op::Min:
            out = b < a ? b : a;
            break;
        case Op::Max:
            out = a < b ? b : a;
            break;
        case Op::Sqrt:
            out = std::sqrt(a);
            break;
        case Op::ToFloat:
            out = a;
            break;
        default:
            return {};
    }
    if (std::isnan(out)) return {.problem = "this is not a number"};
    if (std::isinf(out)) return {.problem = "this is too large for a float"};
    return {.value = out};
}

}  // namespace meld::check
