// Terms of long chains, a + b + c + ... or a && b && ..., and a ++ b ++ ...: trees whose depth grows with the logarithm of the length, so
// that every walk over terms may recur, and Clang's over what is emitted.
#include "compiler/check/names/scope.h"
#include "compiler/check/program/operators.h"
#include "runtime/base/assert.h"

namespace meld::check {

namespace {

// So many operators are a tree.
constexpr std::size_t kShort = 16;
// How deep the term of a chain of a million operators is: that of one in the operand of another is deeper.
constexpr int kDepth = 16 + 16;

// How lists and strings are grouped makes no difference, so they are joined in pairs: each element is copied a few times.
Term in_pairs(std::vector<Term>& operands, std::size_t begin, std::size_t end, const Type& type) {
    if (end - begin == 1) return std::move(operands[begin]);
    const std::size_t middle = begin + (end - begin) / 2;
    Term term;
    term.op = Op::Append;
    term.type = type;
    term.operands.push_back(in_pairs(operands, begin, middle, type));
    term.operands.push_back(in_pairs(operands, middle, end, type));
    term.span = term.operands[0].span.to(term.operands[1].span);
    return term;
}

}  // namespace

Term Scope::chain(const syntax::Chain& c, Span span) {
    MELD_EXPECT(c.operands.size() == c.ops.size() + 1, "{} operators between {} operands", c.ops.size(), c.operands.size());
    const Op op = op_of(c.ops.front());
    const bool logic = op == Op::And || op == Op::Or;
    depth_ += kDepth;
    Term term = op == Op::Append
                    ? appended(c, span)
                    : chain_from(resolve(*c.operands.front(), logic ? Type::Bool : Type::Error, fmt::format("`{}`", sign_of(op))), c, 0,
                                 c.ops.size());
    depth_ -= kDepth;
    term.span = span;
    return term;
}

// The operators from `begin` on, applied to what stands before them. The first half of many is a `let` for the second one, so they are
// computed in the same order as in a tree: an overflow, or a rounding, is where it would be.
Term Scope::chain_from(Term so_far, const syntax::Chain& c, std::size_t begin, std::size_t end) {
    if (end - begin > kShort) {
        const std::size_t middle = begin + (end - begin) / 2;
        Term let;
        let.op = Op::Let;
        Term half = chain_from(std::move(so_far), c, begin, middle);
        let.span = half.span;
        let.variable = fresh("_so_far", half.type, half.span);
        Term variable{.op = Op::Variable, .type = half.type, .span = half.span, .variable = let.variable};
        let.operands.push_back(std::move(half));
        let.operands.push_back(chain_from(std::move(variable), c, middle, end));
        let.type = let.operands[1].type;
        return let;
    }
    for (std::size_t i = begin; i < end; ++i) {
        const Op op = op_of(c.ops[i]);
        const syntax::Expr& right = *c.operands[i + 1];
        const Span left = so_far.span, span = left.to(right.span);
        if (op == Op::And || op == Op::Or) {
            Term term;
            term.op = op;
            term.type = Type::Bool;
            term.span = span;
            term.operands.push_back(std::move(so_far));
            term.operands.push_back(resolve(right, Type::Bool, fmt::format("`{}`", sign_of(op))));
            so_far = std::move(term);
        } else {
            Type type = so_far.type;
            so_far = operation(op, {nullptr, std::move(so_far), std::move(type), left}, right, span);
        }
    }
    return so_far;
}

Term Scope::appended(const syntax::Chain& c, Span span) {
    Term term;
    term.op = Op::Append;
    term.span = span;
    Left before{c.operands.front().get(), {}, infer(*c.operands.front()), c.operands.front()->span};
    const std::size_t errors = report_.error_count();
    for (std::size_t i = 1; i < c.operands.size(); ++i) {
        const syntax::Expr& next = *c.operands[i];
        const std::optional<Type> common = common_type(Op::Append, before, next, infer(next), before.span.to(next.span));
        if (!common || report_.error_count() > errors) return term;
        before = {nullptr, {}, *common, before.span.to(next.span)};
    }
    std::vector<Term> operands;
    operands.reserve(c.operands.size());
    Type type = before.type;
    for (const syntax::ExprPtr& operand : c.operands) {
        operands.push_back(resolve(*operand, type, "`++`"));
        type = refined(type, operands.back().type);
    }
    return in_pairs(operands, 0, operands.size(), type);
}

}  // namespace meld::check
