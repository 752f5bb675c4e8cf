// Emits expressions. A value of more than one word is a ListRef; constants are static data of the module.
#include <algorithm>
#include <bit>

#include "compiler/check/program/library.h"
#include "compiler/check/program/op_info.h"
#include "compiler/check/program/operators.h"
#include "compiler/check/program/types.h"
#include "compiler/emit/type_table.h"
#include "compiler/emit/writer.h"
#include "runtime/base/assert.h"

namespace meld::emit {

using namespace check;

const char* value_member(const Type& type) {
    return type == Type::Float ? "real" : type == Type::Node ? "catom" : type.compound() ? "list" : "integer";
}

std::string compared(const Type& type, const std::string& a, const std::string& b) {
    return type.compound() ? fmt::format("compare_lists(kTypes, {}, {}, {})", type_symbol(type), a, b)
                           : fmt::format("compare({}, {})", a, b);
}

std::string equal(const Type& type, const std::string& a, const std::string& b) {
    return type.compound() ? compared(type, a, b) + " == 0" : fmt::format("{} == {}", a, b);
}

std::string as_word(const std::string& value) { return fmt::format("word({})", value); }

std::string from_word(const Type& type, const std::string& word) {
    return fmt::format("as<{}>({})", cpp_type(type == Type::Error ? Type::Int : type), word);
}

namespace {

std::string real_literal(double v) {
    std::string text = fmt::format("{:#.17g}", v);
    return v < 0 ? "(" + text + ")" : text;
}

// The operator in C++, where it is one and needs no check.
std::string_view plain_infix(Op op) { return op == Op::Equal ? "==" : op == Op::NotEqual ? "!=" : sign_of(op); }

std::string checked(Op op) {
    switch (op) {
        case Op::Add:
            return "checked_add";
        case Op::Subtract:
            return "checked_subtract";
        case Op::Multiply:
            return "checked_multiply";
        case Op::Divide:
            return "checked_divide";
        case Op::Modulo:
            return "checked_modulo";
        case Op::Power:
            return "checked_power";
        default:
            return "";
    }
}

// ---- constants

// The word of a constant as static data, or none. `before` has already declared the lists and strings in it.
std::optional<std::string> constant_word(const Term& t, const Type& type, std::string& before, int& number) {
    switch (t.op) {
        case Op::Int:
            return type == Type::Float ? hex(std::bit_cast<std::uint64_t>(static_cast<double>(t.integer)))
                                       : fmt::format("{}ull", static_cast<std::uint64_t>(t.integer));
        case Op::Bool:
        case Op::Node:
            return fmt::format("{}ull", static_cast<std::uint64_t>(t.integer));
        case Op::Float:
            return hex(std::bit_cast<std::uint64_t>(t.real));
        case Op::ToFloat:
            return constant_word(t.operands[0], Type::Float, before, number);
        case Op::String: {
            if (t.text.empty()) return "0";
            const int mine = number++;
            before += fmt::format(
                "alignas(8) static const char bytes{0}[] = {1}; static const List list{0} = {{reinterpret_cast<const u64*>(bytes{0}), {2}, "
                "0}}; ",
                mine, quoted(t.text), t.text.size());
            return fmt::format("reinterpret_cast<u64>(&list{})", mine);
        }
        case Op::List:
        case Op::Struct:
        case Op::Tuple:
            break;
        default:
            return std::nullopt;
    }
    // A set is sorted when it is made.
    if (type.kind == Type::Kind::Set) return std::nullopt;
    if (t.operands.empty()) return "0";
    std::string items;
    for (std::size_t i = 0; i < t.operands.size(); ++i) {
        const Type part = type == Type::Vec3 ? Type::Float : type.parts[t.op == Op::List ? 0 : i];
        const auto item = constant_word(t.operands[i], part, before, number);
        if (!item) return std::nullopt;
        items += (i ? ", " : "") + *item;
    }
    const int mine = number++;
    before += fmt::format("static const u64 items{0}[] = {{{1}}}; static const List list{0} = {{items{0}, {2}, 0}}; ", mine, items,
                          t.operands.size());
    return fmt::format("reinterpret_cast<u64>(&list{})", mine);
}

// A constant list or string in static memory, or none if it is not constant.
std::optional<std::string> static_value(const Term& t) {
    std::string before;
    int number = 0;
    if (!constant_word(t, t.type, before, number)) return std::nullopt;
    if (number == 0) return "ListRef{}";
    return fmt::format("({{ {}ListRef{{&list{}}}; }})", before, number - 1);
}

// ---- operators

std::string made(const Scope& scope, const Term& t) {
    if (t.operands.empty()) return "ListRef{}";
    std::string items;
    for (std::size_t i = 0; i < t.operands.size(); ++i) {
        const Type part = t.type == Type::Vec3 ? Type::Float : t.type.parts[t.op == Op::List ? 0 : i];
        items += (i ? ", " : "") + as_word(element(scope, t.operands[i], part));
    }
    const std::string list = fmt::format("make_list(*s.e, Words<{}>{{{{{}}}}})", t.operands.size(), items);
    return t.type.kind == Type::Kind::Set
               ? fmt::format("list_to_set(*s.e, {}, kTypes, {}, {})", scope.site(), type_symbol(t.type.parts[0]), list)
               : list;
}

std::string arithmetic(const Scope& scope, const Term& t) {
    if (t.type == Type::Vec3) {
        const char* name = t.op == Op::Add ? "add" : t.op == Op::Subtract ? "subtract" : t.op == Op::Multiply ? "scale" : "divide";
        return fmt::format("library::vector_{}(*s.e, {}, {}, {})", name, scope.site(), term(scope, t.operands[0]),
                           term_as(scope, t.operands[1], t.operands[1].type == Type::Vec3 ? Type::Vec3 : Type::Float));
    }
    const std::string a = term_as(scope, t.operands[0], t.type), b = term_as(scope, t.operands[1], t.type);
    const bool real = t.type == Type::Float;
    if (real && t.op == Op::Power) return fmt::format("__builtin_pow({}, {})", a, b);
    if (real && t.op != Op::Divide && t.op != Op::Modulo) return fmt::format("({} {} {})", a, plain_infix(t.op), b);
    return fmt::format("{}(*s.e, {}, {}, {})", checked(t.op), scope.site(), a, b);
}

std::string comparison(const Scope& scope, const Term& t) {
    const Term &l = t.operands[0], &r = t.operands[1];
    const auto is_empty = [](const Term& list) {
        return (list.op == Op::List && list.operands.empty()) || (list.op == Op::String && list.text.empty());
    };
    if (t.op == Op::Equal || t.op == Op::NotEqual)
        for (const Term* side : {&l, &r})
            if (is_empty(side == &l ? r : l)) return fmt::format("(count_of({}) {} 0)", term(scope, *side), plain_infix(t.op));
    const Type common = l.type == Type::Float || r.type == Type::Float ? Type::Float : refined(l.type, r.type);
    const std::string a = term_as(scope, l, common), b = term_as(scope, r, common);
    if (common.compound()) return fmt::format("({} {} 0)", compared(common, a, b), plain_infix(t.op));
    return fmt::format("({} {} {})", a, plain_infix(t.op), b);
}

std::string parameter(const Scope& scope, const Term& t) {
    const Constant& constant = scope.plan.program.constants[t.constant];
    if (computed_once(constant)) return fmt::format("{}_value(s, {})", constant_name(scope.plan.program, t.constant), scope.site());
    if (constant.computed.valid()) return call(scope, constant.computed, {});
    const Type& type = constant.type;
    const std::string text = fmt::format("s.e->subdomain->parameters[{}].{}", t.constant.index(), value_member(type));
    return type == Type::Bool ? "(" + text + " != 0)" : text;
}

std::string let(const Scope& scope, const Term& t) {
    Scope inner = scope;
    inner.values.insert(t.variable);
    return fmt::format("({{ const {} {} = {}; {}; }})", cpp_type(scope.rule.variables[t.variable].type), scope.local(t.variable),
                       term_as(scope, t.operands[0], scope.rule.variables[t.variable].type), term(inner, t.operands[1]));
}

// ---- calls

bool is_word(const LibraryType& type) { return type.variable == 'T'; }

std::string library_call(const Scope& scope, const Term& t) {
    const LibraryFunction* f = library_function(t.text, t.operands.size());
    MELD_CHECK(f != nullptr && f->op == Op::Library, "rule {}: the library has no {}", scope.rule.name, t.text);
    LibraryBindings bindings;
    for (std::size_t i = 0; i < t.operands.size(); ++i) match(f->parameters[i], t.operands[i].type, bindings);
    match(f->result, t.type, bindings);
    std::string arguments = fmt::format("*s.e, {}", scope.site());
    if (f->compares) arguments += ", kTypes, " + type_symbol(bindings['T']);
    for (std::size_t i = 0; i < t.operands.size(); ++i) {
        const std::string argument = term_as(scope, t.operands[i], substitute(f->parameters[i], bindings));
        arguments += ", " + (is_word(f->parameters[i]) ? as_word(argument) : argument);
    }
    const bool numeric = bindings.contains('N');
    const std::string call = fmt::format("library::{}{}({})", f->cpp, numeric ? "<" + cpp_type(bindings['N']) + ">" : "", arguments);
    return is_word(f->result) ? from_word(t.type, call) : call;
}

// ---- one function a family of operators (compiler/check/program/op_info.h)

std::string leaf(const Scope& scope, const Term& t) {
    switch (t.op) {
        case Op::Variable:
            return scope.value(t.variable);
        case Op::Int:
            return t.integer == INT64_MIN ? "(-__INT64_MAX__ - 1)" : fmt::format("i64{{{}}}", t.integer);
        case Op::Float:
            return real_literal(t.real);
        case Op::Bool:
            return t.integer ? "true" : "false";
        case Op::Node:
            return fmt::format("u64{{{}}}", static_cast<std::uint64_t>(t.integer));
        case Op::Constant:
            return parameter(scope, t);
        default:
            MELD_CHECK(false, "rule {}: a term without a value reached emission", scope.rule.name);
    }
}

std::string compound(const Scope& scope, const Term& t) {
    const auto operand = [&](std::size_t i) { return term(scope, t.operands[i]); };
    switch (t.op) {
        case Op::Cons:
            return fmt::format("cons(*s.e, {}, {})", as_word(element(scope, t.operands[0], t.type.parts[0])), operand(1));
        case Op::ListHead:
            return from_word(t.type, fmt::format("item({}, 0)", operand(0)));
        case Op::ListTail:
            return fmt::format("tail(*s.e, {})", operand(0));
        case Op::IsEmpty:
            return fmt::format("(count_of({}) == 0)", operand(0));
        case Op::Item:
            return from_word(t.type, fmt::format("item({}, {})", operand(0), t.integer));
        case Op::Append:
            return fmt::format("{}(*s.e, {}, {})", t.type == Type::String ? "join_text" : "append", operand(0), operand(1));
        default:
            return static_value(t).value_or(made(scope, t));
    }
}

std::string control(const Scope& scope, const Term& t) {
    const auto operand = [&](std::size_t i) { return term(scope, t.operands[i]); };
    switch (t.op) {
        case Op::Let:
            return let(scope, t);
        case Op::Not:
            return "(!" + operand(0) + ")";
        case Op::If:
            return fmt::format("({} ? {} : {})", operand(0), term_as(scope, t.operands[1], t.type), term_as(scope, t.operands[2], t.type));
        default:
            return fmt::format("({} {} {})", operand(0), plain_infix(t.op), operand(1));
    }
}

std::string asked_of_run(const Scope& scope, const Term& t) {
    const auto operand = [&] { return term(scope, t.operands[0]); };
    switch (t.op) {
        case Op::WorldSize:
            return "s.e->subdomain->world_catoms";
        case Op::Fresh:
            return t.type == Type::Node ? "fresh_node(*s.e)" : "fresh_int(*s.e)";
        case Op::NewNode:
            return "s.e->host->new_node(s.e)";
        case Op::Now:
            return "s.e->subdomain->now";
        case Op::Ticks:
            return fmt::format("ticks_of(*s.e, {})", operand());
        case Op::Due:
            return fmt::format("due(*s.e, {})", operand());
        default:
            return fmt::format("s.e->host->next_hop(s.e, {})", operand());
    }
}

std::string number(const Scope& scope, const Term& t) {
    const auto operand = [&] { return term(scope, t.operands[0]); };
    switch (t.op) {
        case Op::Negate:
            if (t.type == Type::Vec3) return fmt::format("library::vector_scale(*s.e, {}, {}, -1.0)", scope.site(), operand());
            return t.type == Type::Float ? "(-" + operand() + ")"
                                         : fmt::format("checked_subtract(*s.e, {}, 0, {})", scope.site(), operand());
        case Op::ToFloat:
            return fmt::format("static_cast<double>({})", operand());
        case Op::Min:
        case Op::Max:
            return fmt::format("{}_of({}, {})", t.op == Op::Min ? "least" : "greatest", term_as(scope, t.operands[0], t.type),
                               term_as(scope, t.operands[1], t.type));
        case Op::Abs:
            return t.type == Type::Float ? fmt::format("__builtin_fabs({})", operand())
                                         : fmt::format("checked_abs(*s.e, {}, {})", scope.site(), operand());
        case Op::Truncate:
            return fmt::format("checked_truncate(*s.e, {}, {})", scope.site(), operand());
        case Op::Sqrt:
            return fmt::format("__builtin_sqrt({})", operand());
        default:
            return fmt::format("static_cast<i64>({})", operand());
    }
}

}  // namespace

std::string static_list(const Term& t, int& number, Writer& w) {
    std::string before;
    const auto word = constant_word(t, t.type, before, number);
    MELD_CHECK(word, "a constant that is none reached emission");
    if (*word == "0") return "nullptr";
    w.raw(before);
    return fmt::format("&list{}", number - 1);
}

std::string term_as(const Scope& scope, const Term& t, const Type& type) {
    if (type == Type::Float && t.type == Type::Int) return fmt::format("static_cast<double>({})", term(scope, t));
    return term(scope, t);
}

std::string element(const Scope& scope, const Term& t, const Type& type) {
    const std::string value = term_as(scope, t, type);
    const bool sure = type != Type::Float || t.op == Op::Float || t.is_variable();
    return sure ? value : fmt::format("checked_real(*s.e, {}, {})", scope.site(), value);
}

std::string literal_word(const Term& t, const Type& type, std::string& before, int& number) {
    const std::optional<std::string> word = constant_word(t, type, before, number);
    MELD_CHECK(word, "a literal of type {} is none", type_name(type));
    return *word;
}

std::string term(const Scope& scope, const Term& t) {
    if (const auto kept = scope.kept.find(&t); kept != scope.kept.end()) return kept->second;
    switch (info(t.op).family) {
        case OpInfo::Family::Leaf:
            return leaf(scope, t);
        case OpInfo::Family::Compound:
            return compound(scope, t);
        case OpInfo::Family::Control:
            return control(scope, t);
        case OpInfo::Family::Call:
            return t.op == Op::Call ? call(scope, t.function, t.operands) : library_call(scope, t);
        case OpInfo::Family::Run:
            return asked_of_run(scope, t);
        case OpInfo::Family::Number:
            return number(scope, t);
        case OpInfo::Family::Arithmetic:
            return arithmetic(scope, t);
        case OpInfo::Family::Comparison:
            return comparison(scope, t);
    }
    MELD_CHECK(false, "rule {}: a term without a value reached emission", scope.rule.name);
}

}  // namespace meld::emit
