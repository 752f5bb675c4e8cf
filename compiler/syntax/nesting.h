// Finds items nested so deeply that walking their tree by recursion would be unsafe, before the tree is built.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "compiler/syntax/tokens.h"

namespace meld::syntax {

// The index of the first token between begin and end with more than `limit` levels of brackets and operators around or before it. The count
// is an upper bound of the depth of the tree: each bracket is a level, each `if` and `let`, and each operator; but a chain of operators,
// a + b + c + ..., is never deeper than depth_of_chain(), however long it is.
std::optional<std::size_t> too_deep(const std::vector<Token>& tokens, std::size_t begin, std::size_t end, std::size_t limit);

}  // namespace meld::syntax
