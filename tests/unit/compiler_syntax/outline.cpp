// Writes an expression out in prefix form, independent of the printer under test.
#include <fmt/format.h>

#include "parsed.h"

namespace meld::syntax {
namespace {

std::string outline_of(const ExprPtr& expr) { return expr == nullptr ? "-" : outline(*expr); }

std::string list_outline(const char* name, const std::vector<ExprPtr>& list) {
    std::string result = std::string("(") + name;
    for (const ExprPtr& element : list) result += " " + outline_of(element);
    return result + ")";
}

struct Outline {
    std::string operator()(const IntLiteral& node) const { return fmt::format("(int {})", node.value); }
    std::string operator()(const FloatLiteral& node) const { return fmt::format("(float {:a})", node.value); }
    std::string operator()(const BoolLiteral& node) const { return node.value ? "true" : "false"; }
    std::string operator()(const StringLiteral& node) const { return fmt::format("(text {})", node.value); }
    std::string operator()(const CatomLiteral& node) const { return fmt::format("(catom {})", node.id); }
    std::string operator()(const WorldSize&) const { return "world"; }
    std::string operator()(const RunArgument& node) const { return fmt::format("(arg {})", node.number); }
    std::string operator()(const Variable& node) const { return node.name; }
    std::string operator()(const Anonymous&) const { return "_"; }
    std::string operator()(const Call& node) const {
        return list_outline((node.name + (node.parentheses ? "()" : "")).c_str(), node.arguments);
    }
    std::string operator()(const Unary& node) const {
        return fmt::format("(unary{} {})", static_cast<int>(node.op), outline_of(node.operand));
    }
    std::string operator()(const Binary& node) const {
        return fmt::format("(binary{} {} {})", static_cast<int>(node.op), outline_of(node.left), outline_of(node.right));
    }
    std::string operator()(const Chain& node) const {
        std::string text = "(chain " + outline_of(node.operands.front());
        for (std::size_t i = 0; i < node.ops.size(); ++i)
            text += fmt::format(" {} {}", static_cast<int>(node.ops[i]), outline_of(node.operands[i + 1]));
        return text + ")";
    }
    std::string operator()(const Conditional& node) const {
        return fmt::format("(if {} {} {})", outline_of(node.condition), outline_of(node.then_value), outline_of(node.else_value));
    }
    std::string operator()(const Let& node) const {
        return fmt::format("(let {} {} {})", node.variable.text, outline_of(node.value), outline_of(node.body));
    }
    std::string operator()(const ListValue& node) const { return "(" + list_outline("list", node.elements) + outline_of(node.rest) + ")"; }
    std::string operator()(const StructValue& node) const { return list_outline("struct", node.fields); }
    std::string operator()(const TupleValue& node) const { return list_outline("tuple", node.fields); }
};

}  // namespace

std::string outline(const Expr& expr) { return std::visit(Outline{}, expr.node); }

}  // namespace meld::syntax
