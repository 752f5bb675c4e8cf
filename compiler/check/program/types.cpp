#include "compiler/check/program/types.h"

#include <algorithm>

namespace meld::check {

using diagnostics::Kind;

const TypeNames& language_types() {
    static const TypeNames names = {{"int", Type::Int},   {"float", Type::Float}, {"bool", Type::Bool},
                                    {"node", Type::Node}, {"catom", Type::Node},  {"module", Type::Node},
                                    {"addr", Type::Node}, {"vec3", Type::Vec3},   {"string", Type::String}};
    return names;
}

namespace {

std::optional<Type::Kind> maker(const std::string& name) {
    if (name == "list") return Type::Kind::List;
    if (name == "set") return Type::Kind::Set;
    if (name == "array") return Type::Kind::Array;
    if (name == "struct") return Type::Kind::Struct;
    if (name == "tuple") return Type::Kind::Tuple;
    return std::nullopt;
}

void unknown_type(const syntax::Type& type, const TypeNames& names, diagnostics::Reporter& report) {
    std::vector<std::string> known = {"list", "set", "array"};
    for (const auto& [name, t] : names) known.push_back(name);
    suggest_type(report.add(Kind::UnknownType, type.span, fmt::format("there is no type `{}`", type.name)), type.name, known);
}

// Whether both are made alike, so that only their parts can differ.
bool alike(const Type& a, const Type& b) { return a.kind == b.kind && a.parts.size() == b.parts.size(); }

}  // namespace

void suggest_type(diagnostics::Diagnostic& d, const std::string& word, const std::vector<std::string>& known) {
    static const std::map<std::string, std::string> elsewhere = {{"integer", "int"}, {"number", "int"},   {"double", "float"},
                                                                 {"real", "float"},  {"boolean", "bool"}, {"text", "string"}};
    const auto other = elsewhere.find(word);
    const std::string near = other != elsewhere.end() ? other->second : diagnostics::nearest_name(word, known);
    if (near.empty()) {
        d.help = "types are int, float, bool, node, string, vec3, list T, set T, array T and :(T, U)";
        return;
    }
    d.did_you_mean(near, d.span, diagnostics::Edit::Fit::Name);
    // A number may be a float.
    d.fixes.back().safe = other != elsewhere.end() && word != "number";
}

Type to_type(const syntax::Type& type, const TypeNames& names, const syntax::Tree& tree, diagnostics::Reporter& report) {
    const auto kind = maker(type.name);
    if (!kind) {
        const auto found = names.find(type.name);
        if (found != names.end()) return found->second;
        if (!tree.is_lost(type.name)) unknown_type(type, names, report);
        return Type::Error;
    }
    Type out{*kind};
    bool known = true;
    for (const syntax::Type& part : type.arguments) {
        out.parts.push_back(to_type(part, names, tree, report));
        known = known && out.parts.back() != Type::Error;
    }
    return known ? out : Type::Error;
}

bool has_unknown(const Type& type) {
    return type.kind == Type::Kind::Error || std::any_of(type.parts.begin(), type.parts.end(), has_unknown);
}

std::optional<Type> join(const Type& a, const Type& b) {
    if (a == b || b == Type::Error) return a;
    if (a == Type::Error) return b;
    if (a.numeric() && b.numeric()) return Type::Float;
    if (!alike(a, b)) return std::nullopt;
    Type out{a.kind};
    for (std::size_t i = 0; i < a.parts.size(); ++i) {
        std::optional<Type> part = join(a.parts[i], b.parts[i]);
        if (!part) return std::nullopt;
        out.parts.push_back(std::move(*part));
    }
    return out;
}

bool same(const Type& a, const Type& b) {
    if (a == Type::Error || b == Type::Error) return true;
    return alike(a, b) && std::equal(a.parts.begin(), a.parts.end(), b.parts.begin(), same);
}

Type refined(const Type& type, const Type& other) {
    if (type == Type::Error) return other;
    if (!alike(type, other)) return type;
    Type out = type;
    for (std::size_t i = 0; i < out.parts.size(); ++i) out.parts[i] = refined(out.parts[i], other.parts[i]);
    return out;
}

bool summable(const Type& type) { return type.numeric() || type == Type::Vec3 || type == Type::list_of(Type::Float); }

bool ordered(const Type& type) {
    if (type.kind == Type::Kind::Set || type.kind == Type::Kind::Vec3) return false;
    return std::all_of(type.parts.begin(), type.parts.end(), ordered);
}

}  // namespace meld::check
