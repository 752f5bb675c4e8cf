// Operators in a row: the parser makes a tree of few, and one node of many, at the moment when they become too many for a tree.
#include "compiler/syntax/operators.h"

#include <memory>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::syntax {

namespace {

ExprPtr made(decltype(Expr::node) node, Span span) { return std::make_unique<Expr>(Expr{std::move(node), span}); }

// The operand of a Binary on the side where its chain goes on, and on the other one.
ExprPtr& onward(Binary& node, bool left) { return left ? node.left : node.right; }
ExprPtr& aside(Binary& node, bool left) { return left ? node.right : node.left; }

// Adds an operand at the end of a chain that is built from there.
void extend(Chain& chain, BinaryOp op, ExprPtr operand, bool left) {
    if (left) {
        chain.ops.push_back(op);
        chain.operands.push_back(std::move(operand));
    } else {
        chain.ops.push_front(op);
        chain.operands.push_front(std::move(operand));
    }
}

// The operators of a tree of this level, along the side where it goes on.
std::size_t length(const Expr& tree, Level level, bool left) {
    std::size_t count = 0;
    const Expr* e = &tree;
    for (const Binary* node; (node = std::get_if<Binary>(&e->node)) != nullptr && form(node->op).level == level; ++count)
        e = (left ? node->left : node->right).get();
    return count;
}

// The same tree as a chain.
Chain flat(ExprPtr tree, Level level, bool left) {
    std::vector<Binary> nodes;
    for (Binary* node; (node = std::get_if<Binary>(&tree->node)) != nullptr && form(node->op).level == level;) {
        nodes.push_back(std::move(*node));
        tree = std::move(onward(nodes.back(), left));
    }
    Chain chain;
    chain.operands.push_back(std::move(tree));
    for (std::size_t i = nodes.size(); i-- > 0;) extend(chain, nodes[i].op, std::move(aside(nodes[i], left)), left);
    return chain;
}

}  // namespace

const BinaryForm& form(BinaryOp op) {
    static constexpr BinaryForm kForms[] = {
#define MELD_BINARY(name, spelling, level, groups) {spelling, Level::level, Groups::groups},
#include "compiler/syntax/operators.def"
    };
    return kForms[static_cast<std::size_t>(op)];
}

ExprPtr chained(BinaryOp op, ExprPtr left, ExprPtr right, Span span) {
    MELD_EXPECT(left != nullptr && right != nullptr, "an operator without an operand at {}", span.begin);
    const auto [spelling, level, groups] = form(op);
    const bool to_left = groups == Groups::Left;
    ExprPtr &inner = to_left ? left : right, &operand = to_left ? right : left;
    if (!chains(level)) return made(Binary{op, std::move(left), std::move(right)}, span);
    auto* chain = std::get_if<Chain>(&inner->node);
    if (chain == nullptr || form(chain->ops.front()).level != level) {
        if (length(*inner, level, to_left) < kLongChain) return made(Binary{op, std::move(left), std::move(right)}, span);
        Chain longer = flat(std::move(inner), level, to_left);
        extend(longer, op, std::move(operand), to_left);
        return made(std::move(longer), span);
    }
    extend(*chain, op, std::move(operand), to_left);
    inner->span = span;
    return std::move(inner);
}

// Lists with a rest are joined when there are many of them, so that few elements are moved more than once.
ExprPtr chained_list(ExprPtr first, ExprPtr rest, Span span) {
    MELD_EXPECT(first != nullptr && rest != nullptr, "a list without a part at {}", span.begin);
    ListValue all;
    all.elements.push_back(std::move(first));
    all.rest = std::move(rest);
    std::size_t count = 0;
    for (const ListValue* node = &all; node != nullptr && node->rest != nullptr; ++count) node = std::get_if<ListValue>(&node->rest->node);
    while (count > kLongChain && all.rest != nullptr) {
        auto* next = std::get_if<ListValue>(&all.rest->node);
        if (next == nullptr) break;
        // The rest of this one may be the node that holds it.
        ListValue tail = std::move(*next);
        for (ExprPtr& element : tail.elements) all.elements.push_back(std::move(element));
        all.rest = std::move(tail.rest);
    }
    return made(std::move(all), span);
}

}  // namespace meld::syntax
