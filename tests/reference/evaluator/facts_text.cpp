#include "tests/reference/evaluator/facts_text.h"

#include <algorithm>
#include <charconv>
#include <string>

namespace meld::reference {

bool Pattern::whole() const {
    return std::ranges::all_of(arguments, [](const auto& a) { return a.has_value(); });
}

bool Pattern::fits(const Row& row) const {
    return row.size() == arguments.size() &&
           std::ranges::equal(row, arguments, [](const Value& value, const auto& wanted) { return !wanted || *wanted == value; });
}

Row Pattern::row() const {
    Row out;
    for (const auto& a : arguments) out.push_back(*a);
    return out;
}

namespace {

using Kind = check::Type::Kind;

// Each function takes what it reads from the front of the text, or returns nothing.
class Reader {
  public:
    explicit Reader(std::string_view text) : rest_(text) {}

    std::string_view rest() const { return rest_; }
    bool take(std::string_view word) {
        if (!rest_.starts_with(word)) return false;
        rest_.remove_prefix(word.size());
        return true;
    }

    std::optional<Value> value(const check::Type& type) {
        switch (type.kind) {
            case Kind::Int:
                return number<std::int64_t>();
            case Kind::Node:
                return take("@") ? number<std::int64_t>() : std::nullopt;
            case Kind::Float:
                return number<double>();
            case Kind::Bool:
                if (take("true")) return value_of(true);
                return take("false") ? std::optional(value_of(false)) : std::nullopt;
            case Kind::String:
                return string();
            case Kind::Vec3:
                return items({check::Type::Float, check::Type::Float, check::Type::Float}, "vec3(", ")");
            case Kind::Struct:
                return items(type.parts, ":(", ")");
            case Kind::Tuple:
                return items(type.parts, "(", ")");
            case Kind::Set:
                return list(type.parts.at(0), "{", "}");
            case Kind::List:
            case Kind::Array:
                return list(type.parts.at(0), "[", "]");
            case Kind::Error:
                break;
        }
        return std::nullopt;
    }

    // p(@3, 7, _) of one of the predicates of this name.
    std::optional<Pattern> fact(const Program& program) {
        if (take("stable(")) return stable(program);
        const std::string name(take_name());
        const std::string_view arguments = rest_;
        for (const PredicateId id : program.predicates.ids()) {
            if (program.predicates[id].name != name) continue;
            rest_ = arguments;
            if (auto found = arguments_of(program, id)) return found;
        }
        return std::nullopt;
    }

  private:
    template <class Number>
    std::optional<Value> number() {
        Number is{};
        const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), is);
        if (error != std::errc{}) return std::nullopt;
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        return value_of(is);
    }
    // No string of a random program has anything that is written as more than itself.
    std::optional<Value> string() {
        if (!take("\"")) return std::nullopt;
        const std::size_t end = rest_.find('"');
        if (end == std::string_view::npos || rest_.substr(0, end).find('\\') != std::string_view::npos) return std::nullopt;
        Value out{std::string(rest_.substr(0, end))};
        rest_.remove_prefix(end + 1);
        return out;
    }
    std::optional<Value> items(const std::vector<check::Type>& types, std::string_view open, std::string_view close) {
        if (!take(open)) return std::nullopt;
        Values out;
        for (const check::Type& type : types) {
            if (!out.empty() && !take(", ")) return std::nullopt;
            const std::optional<Value> item = value(type);
            if (!item) return std::nullopt;
            out.push_back(*item);
        }
        return take(close) ? std::optional(value_of(std::move(out))) : std::nullopt;
    }
    std::optional<Value> list(const check::Type& type, std::string_view open, std::string_view close) {
        if (!take(open)) return std::nullopt;
        Values out;
        while (!take(close)) {
            if (!out.empty() && !take(", ")) return std::nullopt;
            const std::optional<Value> item = value(type);
            if (!item) return std::nullopt;
            out.push_back(*item);
        }
        return value_of(std::move(out));
    }
    std::string_view take_name() {
        const std::string_view name = rest_.substr(0, rest_.find('('));
        rest_.remove_prefix(name.size());
        return name;
    }
    std::optional<Pattern> arguments_of(const Program& program, PredicateId id) {
        if (!take("(")) return std::nullopt;
        Pattern out{.predicate = id, .arguments = {}};
        for (const check::Argument& argument : program.predicates[id].arguments) {
            if (!out.arguments.empty() && !take(", ")) return std::nullopt;
            if (take("_")) {
                out.arguments.emplace_back();
                continue;
            }
            const std::optional<Value> is = value(argument.type);
            if (!is) return std::nullopt;
            out.arguments.emplace_back(is);
        }
        return take(")") ? std::optional(std::move(out)) : std::nullopt;
    }
    // What stands for it is a predicate of the compiler's, p@stable5.
    std::optional<Pattern> stable(const Program& program) {
        const std::string name(take_name());
        const std::string_view arguments = rest_;
        for (const PredicateId id : program.predicates.ids()) {
            const std::string& own = program.predicates[id].name;
            if (!own.starts_with(name + "@stable")) continue;
            rest_ = arguments;
            auto found = arguments_of(program, id);
            if (found && take(", " + own.substr(name.size() + 7) + ")")) return found;
        }
        return std::nullopt;
    }

    std::string_view rest_;
};

}  // namespace

std::optional<Value> parse_value(const check::Type& type, std::string_view text) {
    Reader reader(text);
    std::optional<Value> out = reader.value(type);
    return reader.rest().empty() ? out : std::nullopt;
}

std::optional<Pattern> take_fact(const Program& program, std::string_view& text) {
    Reader reader(text);
    std::optional<Pattern> out = reader.fact(program);
    if (out) text = reader.rest();
    return out;
}

std::optional<Pattern> parse_fact(const Program& program, std::string_view text) {
    std::optional<Pattern> out = take_fact(program, text);
    return text.empty() ? out : std::nullopt;
}

std::optional<std::int64_t> number_after(std::string_view text, std::string_view words) {
    const std::size_t at = text.find(words);
    if (at == std::string_view::npos) return std::nullopt;
    std::int64_t out = 0;
    const std::string_view rest = text.substr(at + words.size());
    return std::from_chars(rest.data(), rest.data() + rest.size(), out).ec == std::errc{} ? std::optional(out) : std::nullopt;
}

}  // namespace meld::reference
