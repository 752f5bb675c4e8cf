// What the passes need to know of each operator, as one table: a new operator of check::Op gets its row there.
#pragma once

#include <cstdint>

#include "compiler/check/program/term.h"

namespace meld::check {

struct OpInfo {
    Op op;
    // What it does, so that whoever computes or emits terms treats one family in one function.
    enum class Family : std::uint8_t {
        Leaf,        // A variable, a constant or a literal of one word.
        Compound,    // Makes or takes apart lists, sets, structs, tuples and strings.
        Control,     // Computes only some of its operands, binds a variable, or negates a truth value.
        Call,        // Of the program or of the library.
        Run,         // Asks the run: for the tick, the world, or something new.
        Number,      // A function of numbers that is no operator between two operands.
        Arithmetic,  // + - * / % ^
        Comparison,
    } family;
    // How many operands it takes; kMany where the term itself says it.
    std::int8_t operands;
    enum Property : std::uint8_t {
        kPartial = 1,    // Has no value for some operands, such as a division by zero.
        kOverflows = 2,  // Its value may be too large.
        kDraws = 4,      // Has another value each time that it is computed.
        kDear = 8,       // Costs more than a test whether the value is known already.
        kMoves = 16,     // In a test: may be computed at a neighbour before an aggregate of it (plan/passes/push.cpp).
        kOffers = 32,    // In a value offered to neighbours: computed again to see whom a change concerns (emit/concerned.cpp).
    };
    std::uint8_t properties = 0;

    static constexpr std::int8_t kMany = -1;
    // Whether it has one of these properties.
    constexpr bool has(unsigned any) const { return (properties & any) != 0; }
};

const OpInfo& info(Op op);

}  // namespace meld::check
