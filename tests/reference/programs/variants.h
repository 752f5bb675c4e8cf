// Programs that say the same in other words, and the same world with other numbers: views must not differ.
#pragma once

#include <map>

#include "compiler/check/program/program.h"
#include "tests/reference/evaluator/value.h"
#include "tests/reference/programs/draft.h"

namespace meld::reference {

// Without the linear rules, whose outcome depends on which fires first.
Draft views_of(const Draft& draft);

// What is written in another way; several at once by the seed.
struct Variation {
    bool reordered = false;  // Rules and declarations in another order, and the atoms of each body.
    bool redundant = false;  // Atoms twice in a body.
    bool split = false;      // A rule for those derivations that meet a condition, and one for the others.
    bool renamed = false;    // Predicates.
    bool permuted = false;   // The numbers of nodes: of a program that cannot tell them.
};
std::string describe(const Variation& variation);

struct Varied {
    Trial trial;
    // For each name of the program its name in the other one,
    std::map<std::string, std::string> names = {};
    // and for the nodes that have another number there, which.
    std::map<std::int64_t, std::int64_t> numbers = {};
    std::uint64_t changes = 0;  // How much is otherwise.
};
// `program` is the trial's, of which there are no linear rules. Permuted: the world must be a graph.
Varied vary(const Trial& trial, const check::Program& program, const Variation& variation, std::uint64_t seed);

// Whether the views of the variants are the same: not where history decides about one of them, or the order of nodes.
bool comparable(const check::Program& program, const Variation& variation);

// The facts of a program as those of its variant; both by the predicates of their programs.
Facts translate(const check::Program& program, const Facts& facts, const check::Program& other, const Varied& varied);

}  // namespace meld::reference
