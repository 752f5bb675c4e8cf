// Printing and parsing of values.
#include "runtime/engine/tuple/value_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "runtime/base/terminal/terminal_text.h"

namespace meld::tuple {

namespace {

std::string print_float(double real) {
    char buffer[40];
    std::string text(buffer, std::to_chars(buffer, buffer + sizeof buffer, real).ptr);
    if (text.find_first_of(".eni") == std::string::npos) text += ".0";
    return text;
}

// The brackets around the items.
std::pair<std::string_view, std::string_view> brackets(ValueType kind) {
    switch (kind) {
        case ValueType::Set:
            return {"{", "}"};
        case ValueType::Struct:
            return {":(", ")"};
        case ValueType::Tuple:
            return {"(", ")"};
        case ValueType::Vec3:
            return {"vec3(", ")"};
        default:
            return {"[", "]"};
    }
}

// With a backslash before a backslash and before `also`, and line breaks, tabs and what is no visible text as escapes.
std::string escaped(std::string_view rest, char also) {
    std::string text;
    while (!rest.empty()) {
        const char c = rest.front();
        const std::size_t size = visible_character(rest);
        if (c == also || c == '\\')
            text += std::string("\\") + c;
        else if (c == '\n')
            text += "\\n";
        else if (c == '\t')
            text += "\\t";
        else if (c == '\r')
            text += "\\r";
        else if (size == 0)
            text += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
        else
            text += rest.substr(0, size);
        rest.remove_prefix(std::max<std::size_t>(1, size));
    }
    return text;
}

}  // namespace

std::string print_text(std::string_view bytes) { return '"' + escaped(bytes, '"') + '"'; }

std::string print_plain(Type type, Value v) {
    return type.kind() == ValueType::String ? escaped(bytes_of(v.list), '\\') : print_value(type, v);
}

std::string print_value(Type type, Value v) {
    switch (type.kind()) {
        case ValueType::Int:
            return std::to_string(v.integer);
        case ValueType::Bool:
            return v.integer ? "true" : "false";
        case ValueType::Node:
            return "@" + std::to_string(v.catom);
        case ValueType::Float:
            return print_float(v.real);
        case ValueType::String:
            return print_text(bytes_of(v.list));
        default:
            break;
    }
    const auto [open, close] = brackets(type.kind());
    std::string text(open);
    for (std::size_t i = 0; i < length(v.list); ++i) text += (i == 0 ? "" : ", ") + print_value(type.item(i), item(v.list, i));
    return text.append(close);
}

std::string type_name(Type type) {
    switch (type.kind()) {
        case ValueType::Int:
            return "int";
        case ValueType::Float:
            return "float";
        case ValueType::Bool:
            return "bool";
        case ValueType::Node:
            return "node";
        case ValueType::String:
            return "string";
        case ValueType::Vec3:
            return "vec3";
        case ValueType::List:
            return "list " + type_name(type.item(0));
        case ValueType::Set:
            return "set " + type_name(type.item(0));
        case ValueType::Array:
            return "array " + type_name(type.item(0));
        case ValueType::Struct:
        case ValueType::Tuple:
            break;
    }
    std::string text = type.kind() == ValueType::Struct ? ":(" : "(";
    for (std::size_t i = 0; i < type.field_count(); ++i) text += (i == 0 ? "" : ", ") + type_name(type.item(i));
    return text + ")";
}

namespace {

bool blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

// An example of a value of a type, for help.
std::string example(Type type) {
    switch (type.kind()) {
        case ValueType::Int:
            return "12";
        case ValueType::Float:
            return "0.5";
        case ValueType::Bool:
            return "true";
        case ValueType::Node:
            return "@7";
        case ValueType::String:
            return "\"text\"";
        default:
            break;
    }
    const auto [open, close] = brackets(type.kind());
    std::string text(open);
    const std::size_t count = type.has_fields() ? type.field_count() : 2;
    for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : ", ") + example(type.item(i));
    return text.append(close);
}

// Recursive descent: each function reads one value from the front of `rest`, or returns false.
class Parser {
  public:
    Parser(std::string_view text, Arena& arena) : rest_(text), arena_(arena) {}

    bool value(Type type, Value& out) {
        skip();
        if (type.kind() != ValueType::String && rest_.starts_with('"')) return in_quotes(type, out);
        switch (type.kind()) {
            case ValueType::Int:
                return number(out.integer);
            case ValueType::Float:
                return number(out.real) && std::isfinite(out.real) && (out = normal(ValueType::Float, out), true);
            case ValueType::Bool:
                out.integer = rest_.starts_with("true");
                return word("true") || word("false");
            case ValueType::Node:
                return (take("@") || take("#")) && !rest_.starts_with('-') && number(out.catom);
            case ValueType::String: {
                std::string text;
                if (!string(text)) return false;
                out.list = arena_.text(text);
                return true;
            }
            default:
                return items(type, out);
        }
    }
    // "text" with its escapes.
    bool string(std::string& text) {
        if (!take("\"")) return false;
        while (!rest_.empty() && rest_.front() != '"') {
            const char c = next();
            if (c != '\\') {
                text += c;
                continue;
            }
            if (rest_.empty() || !escape(text)) return false;
        }
        return take("\"");
    }
    bool at_end() {
        skip();
        return rest_.empty();
    }

  private:
    bool in_quotes(Type type, Value& out) {
        std::string inner;
        if (!string(inner)) return false;
        Parser parser(inner, arena_);
        return parser.value(type, out) && parser.at_end();
    }
    bool items(Type type, Value& out) {
        std::vector<u64> found;
        const auto [open, close] = brackets(type.kind());
        if (type.has_fields()) {
            if (!take(open)) return false;
            for (std::size_t i = 0; i < type.field_count(); ++i) {
                if (i > 0 && !take(",")) return false;
                if (!one(type.item(i), found)) return false;
            }
            if (!take(close)) return false;
        } else if (type.kind() == ValueType::Set || !word("nil")) {
            if (!take(open)) return false;
            while (!take(close)) {
                if (!found.empty() && !take(",")) return false;
                if (!one(type.item(0), found)) return false;
            }
        }
        if (type.kind() == ValueType::Set) sort(type.item(0), found);
        out.list = arena_.list(found);
        return true;
    }
    bool one(Type type, std::vector<u64>& found) {
        Value v{};
        if (!value(type, v)) return false;
        found.push_back(v.catom);
        return true;
    }
    static void sort(Type element, std::vector<u64>& found) {
        const auto order = [&](u64 a, u64 b) { return compare(element, std::bit_cast<Value>(a), std::bit_cast<Value>(b)); };
        std::sort(found.begin(), found.end(), [&](u64 a, u64 b) { return order(a, b) < 0; });
        found.erase(std::unique(found.begin(), found.end(), [&](u64 a, u64 b) { return order(a, b) == 0; }), found.end());
    }
    template <class N>
    bool number(N& out) {
        const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), out);
        if (error != std::errc()) return false;
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        return true;
    }
    bool escape(std::string& text) {
        switch (const char c = next()) {
            case 'n':
                text += '\n';
                return true;
            case 't':
                text += '\t';
                return true;
            case 'r':
                text += '\r';
                return true;
            case '"':
            case '\\':
                text += c;
                return true;
            case 'x': {
                unsigned byte = 0;
                if (rest_.size() < 2) return false;
                const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + 2, byte, 16);
                if (error != std::errc() || end != rest_.data() + 2) return false;
                text += static_cast<char>(byte);
                rest_.remove_prefix(2);
                return true;
            }
            default:
                return false;
        }
    }
    char next() {
        const char c = rest_.front();
        rest_.remove_prefix(1);
        return c;
    }
    void skip() {
        while (!rest_.empty() && blank(rest_.front())) rest_.remove_prefix(1);
    }
    bool take(std::string_view text) {
        skip();
        if (!rest_.starts_with(text)) return false;
        rest_.remove_prefix(text.size());
        return true;
    }
    // A name that ends here.
    bool word(std::string_view name) {
        skip();
        if (!rest_.starts_with(name)) return false;
        if (rest_.size() > name.size() && (std::isalnum(static_cast<unsigned char>(rest_[name.size()])) != 0 || rest_[name.size()] == '_'))
            return false;
        rest_.remove_prefix(name.size());
        return true;
    }

    std::string_view rest_;
    Arena& arena_;
};

}  // namespace

Result<Value> parse_value(Type type, std::string_view text, Arena& arena) {
    Value v{};
    Parser parser(text, arena);
    if (parser.value(type, v) && parser.at_end()) return v;
    if (type.kind() == ValueType::String) {
        v.list = arena.text(text);
        return v;
    }
    const std::string wanted = type.kind() == ValueType::Node ? "catom" : type_name(type);
    return fail(fmt::format("'{}' is no {}", text, wanted), type.kind() == ValueType::Int     ? "Write a whole number such as 12"
                                                            : type.kind() == ValueType::Float ? "Write a number such as 0.5"
                                                            : type.kind() == ValueType::Bool  ? "Write true or false"
                                                            : type.kind() == ValueType::Node  ? "Write @ and its number, as @7"
                                                                                              : "Write it as " + example(type));
}

}  // namespace meld::tuple
