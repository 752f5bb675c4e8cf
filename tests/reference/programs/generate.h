// Random programs, made rule by rule: each new rule has results on a sample world, so that programs do not die out.
#pragma once

#include "tests/reference/evaluator/value.h"
#include "tests/reference/programs/draft.h"

namespace meld::reference {

struct Generated {
    Draft draft;
    // What the compiler says where it refuses a program that the generator holds to be right.
    std::string refused = {};
    std::uint64_t tried = 0, kept = 0;  // Blocks of rules.
};

// The worlds that a program is for. In graphs there are no cells; a nameless program can tell nodes apart by what they hold and whom they
// are linked with, and not by their numbers or their order.
enum class Suits { Lattices, Graphs, Nameless };
// states: some programs have linear rules alone.
Generated make_program(std::uint64_t seed, Suits suits = Suits::Lattices, bool states = true);
// The most links that a node of a graph may have for this program: none waits for more than 32, and long joins take long.
std::size_t max_degree(const Draft& draft);

}  // namespace meld::reference
