// Blocks of rules that the generator adds to a program: each declares new predicates and derives them from what there is.
#pragma once

#include "tests/reference/programs/body.h"

namespace meld::reference {

struct Block {
    std::vector<Declaration> declarations = {};
    std::vector<DraftRule> rules = {};
    std::vector<Known> known = {};  // What later blocks may read.
    std::vector<retraction::Given> given = {};
};

// names: how many predicates were named before; the block's are numbered from there on.
using MakeBlock = Block (*)(Random& random, const std::vector<Known>& known, int names);

// Facts that cases give and take.
Block given_block(Random& random, const std::vector<Known>& known, int names);
// A view over up to three links, with tests, negations and aggregates.
Block view_block(Random& random, const std::vector<Known>& known, int names);
// Values in rounds that keep step: no catom has a value of a round before all its neighbours have one of the last.
Block rounds_block(Random& random, const std::vector<Known>& known, int names);
// Sums and counts over links that form cycles: of walks by their lengths, each from the one before, without waiting for anybody.
Block walks_block(Random& random, const std::vector<Known>& known, int names);
// Negations, counts and sums of facts that depend on each other, in rounds.
Block contest_block(Random& random, const std::vector<Known>& known, int names);
// Sets that derive each other, locally and over links.
Block set_recursion_block(Random& random, const std::vector<Known>& known, int names);
// Recursive min and max, with groups and payloads.
Block best_recursion_block(Random& random, const std::vector<Known>& known, int names);
// Recursive min and max whose values improve through what follows from them.
Block improving_block(Random& random, const std::vector<Known>& known, int names);
// A distance, parents by it, and sums towards the root or away from it.
Block tree_block(Random& random, const std::vector<Known>& known, int names);
// A view with an arithmetic error for one value of a given fact, which few worlds give.
Block error_block(Random& random, const std::vector<Known>& known, int names);
// A distance, the greatest one anywhere, and a view that has no value while the second is behind the first.
Block half_settled_block(Random& random, const std::vector<Known>& known, int names);
// Linear facts that wander, meet and give persistent facts.
Block linear_block(Random& random, const std::vector<Known>& known, int names);
// The same with facts that go to nodes known by value.
Block far_block(Random& random, const std::vector<Known>& known, int names);
// Linear facts that update another one, each in turn or all in one pass.
Block sweep_block(Random& random, const std::vector<Known>& known, int names);
// Tables of linear and other facts, joined by any of their arguments.
Block table_block(Random& random, const std::vector<Known>& known, int names);
// All of a program: linear facts that are the states of catoms, and messages between them.
Block state_block(Random& random, const std::vector<Known>& known, int names);

}  // namespace meld::reference
