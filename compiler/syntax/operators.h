// How tightly operators bind, and trees of long chains of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "compiler/syntax/tree.h"

namespace meld::syntax {

// The levels of grammar.y, loosest first.
enum class Level { Or, And, Not, Compare, Cons, Append, Add, Multiply, Negate, Power, Primary };

// How `a op b op c` is read.
enum class Groups { Left, Right, Neither };

struct BinaryForm {
    std::string_view spelling;
    Level level;
    Groups groups;

    // The loosest expression that stands on each side without brackets.
    Level left() const { return groups == Groups::Left ? level : tighter(); }
    Level right() const { return groups == Groups::Right ? level : tighter(); }
    Level tighter() const { return static_cast<Level>(static_cast<int>(level) + 1); }
};
const BinaryForm& form(BinaryOp op);

// ---- chains

// `a op b op c ...` is a tree of Binary up to this many operators of one level, and a Chain with more of them; `a :: b :: c ...` is a list
// with a rest for each, and one list with more of them. So every walk over a tree may recur.
inline constexpr std::size_t kLongChain = 32;
// Whether operators of this level stand in chains of any length. Those of the others are few: each needs a bracket, or is refused.
constexpr bool chains(Level level) {
    return level == Level::Or || level == Level::And || level == Level::Cons || level == Level::Append || level == Level::Add ||
           level == Level::Multiply;
}
// How deep the tree of so many operators of one level is at most, here and in the checked program: a Chain is cut in halves there.
constexpr std::size_t depth_of_chain(Level level, std::size_t operators) {
    return chains(level) ? std::min(operators, kLongChain + 1) : operators;
}

// The expression `left op right`, and `first :: rest`.
ExprPtr chained(BinaryOp op, ExprPtr left, ExprPtr right, Span span);
ExprPtr chained_list(ExprPtr first, ExprPtr rest, Span span);

}  // namespace meld::syntax
