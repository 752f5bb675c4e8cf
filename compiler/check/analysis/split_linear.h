// The two rules to write for one that consumes linear facts of two catoms.
#pragma once

#include <optional>
#include <string>

#include "compiler/check/program/program.h"

namespace meld::check {

// token(A, N), neighbor(A, B), wish(B, W) -o p(A, N + W).
struct Split {
    std::string kept, sent;   // The catoms: A, where both are consumed, and B, whose facts are sent.
    std::string declaration;  // type linear wish-here(node, node, int).
    std::string send;         // wish(B, W), neighbor(A, B) -o wish-here(A, B, W).
    std::string consume;      // token(A, N), neighbor(A, B), wish-here(A, B, W) -o p(A, N + W).
};

// Sends the linear facts at `there` to `here`, where the others are; the other way where a link that is consumed at `here` leads there.
// None if the rule consumes facts of a third catom, only reads some elsewhere, or takes two of one predicate, which would both be sent.
std::optional<Split> split_linear(const Program& program, const Rule& rule, VariableId here, VariableId there);

}  // namespace meld::check
