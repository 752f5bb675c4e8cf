// How rules use the value of a min or max that they read: they test whether there is one, or compute with it.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "compiler/check/program/program.h"

namespace meld::check {

struct ValueRead {
    // None: there is no such value. Exists: whether the group has a value that passes `tests`; once true, that stays true while the value
    // improves. Used: the value goes on into the head or other facts.
    enum class Kind { None, Exists, Used } kind = Kind::None;
    std::vector<std::size_t> tests = {};  // Clauses of the rule's body, comparisons of the value with constants.
};
// For an atom of the rule's body.
ValueRead value_read(const Program& program, const Rule& rule, const Atom& atom);

// A view m(B, max(X, Y)) :- m(A, X), q(B, Y) of a max as the two rules with X and with Y in the head, which together derive the same value.
// Nothing: its head is no such thing.
std::optional<std::array<Rule, 2>> sides_of_best(const Program& program, const Rule& rule);

// How often a rule mentions a variable.
std::size_t uses(const Rule& rule, VariableId v);
// Whether an expression, or one that the body makes it equal to, mentions the value.
bool computed_from(const Rule& rule, const Term& expression, VariableId value);
// Whether an expression over this value may be better than the value itself: for a max X + 1, for a min X - 1. If that depends on something
// else, as in X + W, it counts as no improvement. Ever: without a limit; max(X - 1, 0) of a min has a limit.
enum class Improves { ToALimit, Ever };
bool improves(const Rule& rule, const Term& expression, VariableId value, Aggregate aggregate, Improves how);

}  // namespace meld::check
