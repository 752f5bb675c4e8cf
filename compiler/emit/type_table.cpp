#include "compiler/emit/type_table.h"

#include <algorithm>
#include <cctype>
#include <functional>

namespace meld::emit {

using check::Type;

const char* value_type(const Type& t) {
    switch (t.kind) {
        case Type::Kind::Error:
        case Type::Kind::Int:
            return "Int";
        case Type::Kind::Float:
            return "Float";
        case Type::Kind::Bool:
            return "Bool";
        case Type::Kind::Node:
            return "Node";
        case Type::Kind::String:
            return "String";
        case Type::Kind::List:
            return "List";
        case Type::Kind::Set:
            return "Set";
        case Type::Kind::Array:
            return "Array";
        case Type::Kind::Struct:
            return "Struct";
        case Type::Kind::Tuple:
            return "Tuple";
        case Type::Kind::Vec3:
            return "Vec3";
    }
    return "";
}

std::string type_symbol(const Type& type) {
    const auto name = [](const auto& self, const Type& t) -> std::string {
        std::string text = t == Type::Error ? "int" : value_type(t);
        for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        // The number of fields makes the name unique: (int, (int, int)) is not (int, (int), int).
        if (t.kind == Type::Kind::Struct || t.kind == Type::Kind::Tuple) text += std::to_string(t.parts.size());
        for (const Type& part : t.parts) text += "_" + self(self, part);
        return text;
    };
    return "kType_" + name(name, type);
}

namespace {

// A type that nothing determines, such as that of an element of [], is int.
Type settled(const Type& type) {
    if (type == Type::Error) return Type::Int;
    Type out = type;
    for (Type& part : out.parts) part = settled(part);
    return out;
}

void each_term(const std::vector<check::Clause>& body, const std::function<void(const check::Term&)>& visit) {
    for (const check::Clause& c : body) {
        for (const check::Term& t : c.atom.arguments) visit(t);
        visit(c.test);
        visit(c.parameter);
        each_term(c.inner, visit);
    }
}

}  // namespace

TypeTable::TypeTable(const plan::Plan& plan) : types_{Type::Int, Type::Float, Type::Bool, Type::Node} {
    const check::Program& program = plan.program;
    for (const check::Predicate& p : program.predicates)
        for (const check::Argument& a : p.arguments) add(a.type);
    for (const check::Constant& c : program.constants) add(c.type);
    for (const check::Function& f : program.functions) {
        for (const check::Variable& v : f.variables) add(v.type);
        add(f.result);
        add(f.body);
    }
    for (const check::Rule& r : program.rules) {
        for (const check::Variable& v : r.variables) add(v.type);
        const auto visit = [this](const check::Term& t) { add(t); };
        each_term(r.body, visit);
        check::each_head(r.heads, [&](const check::Head& h) {
            for (const check::Term& t : h.atom.arguments) add(t);
            add(h.term);
            each_term(h.body, visit);
            for (const check::HeadAggregate& f : h.aggregates) add(f.parameter);
        });
    }
}

void TypeTable::add(const check::Term& term) {
    check::each_subterm(term, [this](const check::Term& t) { add(t.type); });
}

void TypeTable::add(const Type& type) {
    const Type known = settled(type);
    if (std::find(types_.begin(), types_.end(), known) != types_.end()) return;
    for (const Type& part : known.parts) add(part);
    types_.push_back(known);
}

std::size_t TypeTable::number(const Type& type) const {
    const auto found = std::find(types_.begin(), types_.end(), settled(type));
    MELD_CHECK(found != types_.end(), "the type {} has no number", check::type_name(type));
    return static_cast<std::size_t>(found - types_.begin());
}

void TypeTable::emit(Writer& w) const {
    for (std::size_t i = 0; i < types_.size(); ++i) {
        if (types_[i].parts.empty()) continue;
        std::string parts;
        for (const Type& part : types_[i].parts) parts += fmt::format("{}{}", parts.empty() ? "" : ", ", number(part));
        w.line("static constexpr u16 kParts{}[] = {{{}}};", i, parts);
    }
    for (std::size_t i = 0; i < types_.size(); ++i) w.line("static constexpr u16 {} = {};", type_symbol(types_[i]), i);
    w.open("static constexpr TypeInfo kTypes[] = {");
    for (std::size_t i = 0; i < types_.size(); ++i)
        w.line("{{ValueType::{}, {}, {}}},  // {}", value_type(types_[i]), types_[i].parts.size(),
               types_[i].parts.empty() ? "nullptr" : fmt::format("kParts{}", i), check::type_name(types_[i]));
    w.close("};");
}

}  // namespace meld::emit
