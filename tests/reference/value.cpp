#include "value.h"

#include <fmt/format.h>

namespace meld::reference {

std::string print(const check::Type& type, const Value& value) {
    if (value.is_real()) {
        const std::string text = fmt::format("{}", value.real());
        return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
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
