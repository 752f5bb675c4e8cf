// Expressions as Meld text, with the brackets that precedence requires.
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "compiler/syntax/operators.h"
#include "compiler/syntax/parse.h"
#include "compiler/syntax/printer.h"
#include "compiler/syntax/tokens.h"
#include "runtime/base/assert.h"

namespace meld::syntax {

namespace {

struct Printed {
    std::string text;
    Level level = Level::Primary;
};

Printed print_leveled(const Expr& expr);

std::string at_least(const Expr& expr, Level level) {
    Printed printed = print_leveled(expr);
    return printed.level < level ? "(" + printed.text + ")" : std::move(printed.text);
}

std::string list_of(const std::vector<ExprPtr>& list) {
    std::string result;
    for (const ExprPtr& element : list) {
        MELD_EXPECT(element != nullptr, "a list with a hole");
        if (!result.empty()) result += ", ";
        result += print(*element);
    }
    return result;
}

std::string float_text(double value) {
    MELD_EXPECT(std::isfinite(value), "a literal that is no number");
    std::array<char, 64> buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
    std::string text(buffer.data(), end);
    // Only digits would be an int.
    const bool marked = text.find_first_of(".e") != std::string::npos;
    return marked ? text : text + ".0";
}

// A negative literal starts with a minus, and binds like one.
Level level_of_number(bool negative) { return negative ? Level::Negate : Level::Primary; }

struct ExprPrinter {
    Printed operator()(const IntLiteral& node) const { return {std::to_string(node.value), level_of_number(node.value < 0)}; }
    Printed operator()(const FloatLiteral& node) const { return {float_text(node.value), level_of_number(std::signbit(node.value))}; }
    Printed operator()(const BoolLiteral& node) const { return {node.value ? "true" : "false"}; }
    Printed operator()(const StringLiteral& node) const { return {quoted_text(node.value)}; }
    Printed operator()(const CatomLiteral& node) const { return {"@" + std::to_string(node.id)}; }
    Printed operator()(const WorldSize&) const { return {"@world"}; }
    Printed operator()(const RunArgument& node) const { return {"@arg" + std::to_string(node.number)}; }
    Printed operator()(const Variable& node) const { return {node.name}; }
    Printed operator()(const Anonymous&) const { return {"_"}; }
    // +00 and @cpus are calls without brackets.
    Printed operator()(const Call& node) const {
        const bool brackets = node.parentheses && node.name.find_first_of("+-@") != 0;
        return {brackets ? node.name + "(" + list_of(node.arguments) + ")" : node.name};
    }
    Printed operator()(const Unary& node) const {
        if (node.op == UnaryOp::Not) return {"~" + at_least(*node.operand, Level::Not), Level::Not};
        // -3 would be read as one literal.
        const Printed operand = print_leveled(*node.operand);
        const bool literal =
            std::holds_alternative<IntLiteral>(node.operand->node) || std::holds_alternative<FloatLiteral>(node.operand->node);
        if (literal && operand.level == Level::Primary) return {"-(" + operand.text + ")", Level::Negate};
        return {operand.level < Level::Negate ? "-(" + operand.text + ")" : "-" + operand.text, Level::Negate};
    }
    Printed operator()(const Binary& node) const {
        const BinaryForm& binary = form(node.op);
        return {fmt::format("{} {} {}", at_least(*node.left, binary.left()), binary.spelling, at_least(*node.right, binary.right())),
                binary.level};
    }
    Printed operator()(const Chain& node) const {
        const BinaryForm& of = form(node.ops.front());
        const bool to_left = of.groups == Groups::Left;
        std::string text = at_least(*node.operands.front(), to_left ? of.level : of.tighter());
        for (std::size_t i = 0; i < node.ops.size(); ++i) {
            const bool last = !to_left && i + 1 == node.ops.size();
            text += fmt::format(" {} {}", form(node.ops[i]).spelling, at_least(*node.operands[i + 1], last ? of.level : of.tighter()));
        }
        return {std::move(text), of.level};
    }
    Printed operator()(const Conditional& node) const {
        return {fmt::format("if {} then {} else {} end", print(*node.condition), print(*node.then_value), print(*node.else_value))};
    }
    Printed operator()(const Let& node) const {
        return {fmt::format("let {} = {} in {} end", node.variable.text, print(*node.value), print(*node.body))};
    }
    Printed operator()(const ListValue& node) const {
        const std::string rest = node.rest == nullptr ? "" : " | " + print(*node.rest);
        return {"[" + list_of(node.elements) + rest + "]"};
    }
    Printed operator()(const StructValue& node) const { return {":(" + list_of(node.fields) + ")"}; }
    Printed operator()(const TupleValue& node) const { return {"(" + list_of(node.fields) + ")"}; }
};

Printed print_leveled(const Expr& expr) { return std::visit(ExprPrinter{}, expr.node); }

}  // namespace

std::string_view spelling(BinaryOp op) { return form(op).spelling; }

std::string quoted_text(std::string_view text) {
    std::string result = "\"";
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char letter = text[i];
        const std::size_t size = utf8_sequence_size(text.substr(i));
        if (letter == '"' || letter == '\\') {
            result += '\\';
            result += letter;
        } else if (letter == '\n') {
            result += "\\n";
        } else if (letter == '\t') {
            result += "\\t";
        } else if (letter == '\r') {
            result += "\\r";
        } else if (size == 0 || static_cast<unsigned char>(letter) < 0x20 || letter == 0x7f) {
            result += fmt::format("\\x{:02x}", static_cast<unsigned char>(letter));
        } else {
            result += text.substr(i, size);
            i += size - 1;
        }
    }
    return result + "\"";
}

std::string plain_decimal(double value) {
    // The largest double has 309 digits before its point, the smallest 1074 behind it.
    std::array<char, 1500> buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed).ptr;
    return std::string(buffer.data(), end);
}

std::string print(const Expr& expr) { return print_leveled(expr).text; }

}  // namespace meld::syntax
