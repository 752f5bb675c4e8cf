#include "compiler/emit/writer.h"

#include <cctype>

namespace meld::emit {

using namespace check;

std::string clean(const std::string& name) {
    std::string out;
    for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
    return out;
}

std::string predicate_name(const Program& program, PredicateId id) {
    std::string name = clean(program.predicates[id].name);
    if (name.empty() || !std::islower(static_cast<unsigned char>(name[0]))) name = "p" + name;
    return fmt::format("{}_{}", name, id.index());
}

std::string record_name(plan::ColumnId id) { return fmt::format("record_{}", id.index()); }

std::string rule_function(const Program& program, plan::RuleId id) {
    const Rule& rule = program.rules[id];
    const std::string head = rule.name.substr(0, rule.name.find('@'));
    return fmt::format("{}_at_line_{}_r{}", "rule_" + clean(head), rule.line, id.index());
}

std::string cpp_type(const Type& type) {
    switch (type.kind) {
        case Type::Kind::Int: return "i64";
        case Type::Kind::Float: return "double";
        case Type::Kind::Bool: return "bool";
        case Type::Kind::Node: return "u64";
        case Type::Kind::Error: break;
        default: return "const List*";
    }
    MELD_CHECK(false, "a value of type {} reached emission", type_name(type));
}

std::string field_name(std::size_t argument) { return fmt::format("a{}", argument); }

std::string hex(std::uint64_t bits) { return fmt::format("{:#x}ull", bits); }

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        const unsigned char u = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') out += std::string("\\") + c;
        else if (c == '\n') out += "\\n";
        else if (u < 32 || u > 126 || c == '?') out += fmt::format("\\{:03o}", u);
        else out += c;
    }
    return out + "\"";
}

std::string Scope::local(plan::VariableId v) const { return fmt::format("{}_{}", clean(rule.variables[v].name), v.index()); }

std::string Scope::at(plan::VariableId v) const { return v == rule.home ? "s.catom" : local(v) + "_at"; }

std::string Scope::port(plan::VariableId v) const { return local(v) + "_port"; }

std::string Scope::value(plan::VariableId v) const {
    if (values.contains(v)) return local(v);
    MELD_CHECK(v == rule.home || places.contains(v), "rule {}: {} has no value", rule.name, rule.variables[v].name);
    return fmt::format("s.g->catom_id[{}]", at(v));
}

namespace {

std::string real_literal(double v) {
    std::string text = fmt::format("{:#.17g}", v);
    return v < 0 ? "(" + text + ")" : text;
}

const char* plain_infix(Op op) {
    switch (op) {
        case Op::Equal: return "==";
        case Op::NotEqual: return "!=";
        case Op::Less: return "<";
        case Op::LessEqual: return "<=";
        case Op::Greater: return ">";
        case Op::GreaterEqual: return ">=";
        case Op::And: return "&&";
        case Op::Or: return "||";
        case Op::Add: return "+";
        case Op::Subtract: return "-";
        case Op::Multiply: return "*";
        default: return nullptr;
    }
}

std::string checked(Op op) {
    switch (op) {
        case Op::Add: return "checked_add";
        case Op::Subtract: return "checked_subtract";
        case Op::Multiply: return "checked_multiply";
        case Op::Divide: return "checked_divide";
        case Op::Modulo: return "checked_modulo";
        case Op::Power: return "checked_power";
        default: return "";
    }
}

std::string arithmetic(const Scope& scope, const Term& t) {
    const std::string a = term_as(scope, t.operands[0], t.type), b = term_as(scope, t.operands[1], t.type);
    const bool real = t.type == Type::Float;
    if (real && t.op == Op::Power) return fmt::format("__builtin_pow({}, {})", a, b);
    if (real && t.op != Op::Divide && t.op != Op::Modulo) return fmt::format("({} {} {})", a, plain_infix(t.op), b);
    return fmt::format("{}(*s.e, {}, {}, {})", checked(t.op), scope.rule_index, a, b);
}

std::string parameter(const Term& t) {
    const char* field = t.type == Type::Float ? "real" : t.type == Type::Node ? "catom" : "integer";
    const std::string text = fmt::format("s.e->part->parameters[{}].{}", t.constant.index(), field);
    return t.type == Type::Bool ? "(" + text + " != 0)" : text;
}

}  // namespace

std::string term_as(const Scope& scope, const Term& t, const Type& type) {
    if (type == Type::Float && t.type == Type::Int) return fmt::format("static_cast<double>({})", term(scope, t));
    return term(scope, t);
}

std::string term(const Scope& scope, const Term& t) {
    const auto operand = [&](std::size_t i) { return term(scope, t.operands[i]); };
    const auto common = [&](std::size_t i) {
        const bool real = t.operands[0].type == Type::Float || t.operands[1].type == Type::Float;
        return term_as(scope, t.operands[i], real ? Type::Float : t.operands[i].type);
    };
    switch (t.op) {
        case Op::Variable: return scope.value(t.variable);
        case Op::Int: return t.integer == INT64_MIN ? "(-__INT64_MAX__ - 1)" : fmt::format("i64{{{}}}", t.integer);
        case Op::Float: return real_literal(t.real);
        case Op::Bool: return t.integer ? "true" : "false";
        case Op::Node: return fmt::format("u64{{{}}}", static_cast<std::uint64_t>(t.integer));
        case Op::Constant: return parameter(t);
        case Op::Negate: return t.type == Type::Float ? "(-" + operand(0) + ")" : fmt::format("checked_subtract(*s.e, {}, 0, {})", scope.rule_index, operand(0));
        case Op::Not: return "(!" + operand(0) + ")";
        case Op::ToFloat: return fmt::format("static_cast<double>({})", operand(0));
        case Op::If: return fmt::format("({} ? {} : {})", operand(0), term_as(scope, t.operands[1], t.type), term_as(scope, t.operands[2], t.type));
        case Op::Min:
        case Op::Max: return fmt::format("{}_of({}, {})", t.op == Op::Min ? "least" : "greatest", term_as(scope, t.operands[0], t.type), term_as(scope, t.operands[1], t.type));
        case Op::Abs: return t.type == Type::Float ? fmt::format("__builtin_fabs({})", operand(0)) : fmt::format("checked_abs(*s.e, {}, {})", scope.rule_index, operand(0));
        case Op::Truncate: return fmt::format("checked_truncate(*s.e, {}, {})", scope.rule_index, operand(0));
        case Op::Sqrt: return fmt::format("__builtin_sqrt({})", operand(0));
        case Op::NodeToInt: return fmt::format("static_cast<i64>({})", operand(0));
        case Op::Add:
        case Op::Subtract:
        case Op::Multiply:
        case Op::Divide:
        case Op::Modulo:
        case Op::Power: return arithmetic(scope, t);
        case Op::Anonymous:
        case Op::String: break;
        default: return fmt::format("({} {} {})", common(0), plain_infix(t.op), common(1));
    }
    MELD_CHECK(false, "rule {}: a term without a value reached emission", scope.rule.name);
}

bool has_view(const plan::Plan& plan, PredicateId id) {
    const Storage s = plan.of(id).storage;
    return s != Storage::Unused && s != Storage::World;
}

}  // namespace meld::emit
