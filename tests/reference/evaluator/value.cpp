#include "tests/reference/evaluator/value.h"

#include <fmt/format.h>

#include <charconv>

namespace meld::reference {

bool Value::operator==(const Value& other) const { return is == other.is; }
std::partial_ordering Value::operator<=>(const Value& other) const { return is <=> other.is; }

std::string print(const check::Type& type, const Value& value) {
    using Kind = check::Type::Kind;
    if (value.is_real()) {
        char buffer[40];
        const std::string text(buffer, std::to_chars(buffer, buffer + sizeof buffer, value.real()).ptr);
        return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
    }
    if (value.is_text()) return "\"" + value.text() + "\"";
    if (value.has_items()) {
        const bool fields = type.kind == Kind::Struct || type.kind == Kind::Tuple;
        std::string text;
        for (std::size_t i = 0; i < value.items().size(); ++i)
            text += (i ? ", " : "") + print(type.parts.empty() ? check::Type::Float : type.parts[fields ? i : 0], value.items()[i]);
        if (type.kind == Kind::Vec3) return "vec3(" + text + ")";
        if (type.kind == Kind::Set) return "{" + text + "}";
        return (type.kind == Kind::Struct ? ":(" : fields ? "(" : "[") + text + (fields ? ")" : "]");
    }
    if (type == check::Type::Bool) return value.truth() ? "true" : "false";
    return fmt::format("{}{}", type == check::Type::Node ? "@" : "", value.integer());
}

std::string print(const Program& program, PredicateId predicate, const Row& row) {
    const check::Predicate& p = program.predicates[predicate];
    std::string text = p.name + "(";
    for (std::size_t i = 0; i < row.size(); ++i) text += (i ? ", " : "") + print(p.arguments[i].type, row[i]);
    return text + ")";
}

}  // namespace meld::reference
