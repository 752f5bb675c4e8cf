// Facts and settings as text that the compiler can read again.
#include "runtime/world/file/given_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace meld::world {
namespace {

bool all_digits(std::string_view text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// Whether the text can stay as it is: a number, a bool, a catom, or a string with its quotes.
bool is_literal(std::string_view text) {
    if (text == "true" || text == "false") return true;
    if (text.starts_with('@')) return all_digits(text.substr(1));
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"') return true;
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size() && std::isfinite(number);
}

std::string quoted(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') result += '\\';
        if (c == '\n') {
            result += "\\n";
        } else {
            result += c;
        }
    }
    return result + '"';
}

// With a point or an exponent, so that it is read as a number of that type again.
std::string float_literal(double number) {
    const std::string text = fmt::format("{}", number);
    return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

// Inside an array a string is a string, unless it names a catom; numbers are numbers.
std::string array_literal(TomlReader& reader, const toml::array& array, std::string_view what) {
    std::string text = "[";
    for (const toml::node& item : array) {
        const std::string* string = item.is_string() ? &**item.as_string() : nullptr;
        text += text.size() > 1 ? ", " : "";
        text += string != nullptr && !string->starts_with('@') ? quoted(*string) : literal(reader, item, what);
    }
    return text + "]";
}

// One of the items of a predicate: a region, or a table of a region and arguments.
void read_item(TomlReader& reader, const toml::node& item, GivenFact fact, std::vector<GivenFact>& facts) {
    fact.place = reader.place(item.source());
    if (item.is_string()) {
        fact.where = read_region(reader, item);
    } else if (item.is_table()) {
        const Section section(reader, *item.as_table(), "a fact", {"where", "args"});
        std::string where;
        section.read("where", where);
        const toml::node* node = section.find("where");
        if (node && node->is_string()) fact.where = read_region(reader, *node);
        const toml::node* arguments = section.find("args");
        if (arguments && !arguments->is_array()) return reader.wrong(arguments->source(), "args " + type_mismatch(*arguments, "an array"));
        for (std::size_t i = 0; arguments && i < arguments->as_array()->size(); ++i) {
            fact.arguments.push_back(literal(reader, *arguments->as_array()->get(i), "an argument"));
        }
    } else {
        return reader.wrong(item.source(), "a fact " + type_mismatch(item, "a region or { where = ..., args = [...] }"));
    }
    facts.push_back(std::move(fact));
}

}  // namespace

Region read_region(TomlReader& reader, const toml::node& node) {
    const Parsed<Region> region = parse_region_text(**node.as_string(), reader.nameable());
    if (region) return *region;
    reader.wrong_in(node, region.error());
    return {};
}

std::string literal(TomlReader& reader, const toml::node& node, std::string_view what) {
    if (node.is_integer()) return fmt::format("{}", **node.as_integer());
    if (node.is_boolean()) return **node.as_boolean() ? "true" : "false";
    if (node.is_floating_point()) {
        const double number = **node.as_floating_point();
        if (!std::isfinite(number)) reader.wrong(node.source(), fmt::format("{} is not a finite number", what));
        return float_literal(number);
    }
    if (node.is_string()) {
        const std::string& text = **node.as_string();
        if (text.starts_with('@') && !is_literal(text)) {
            reader.wrong(node.source(), fmt::format("'{}' names no catom", text), "write @ and its number, as in \"@3\"");
        }
        return is_literal(text) ? text : quoted(text);
    }
    if (node.is_array()) return array_literal(reader, *node.as_array(), what);
    reader.wrong(node.source(), fmt::format("{} {}", what, type_mismatch(node, "a number, a string, an array, true or false")));
    return "0";
}

void read_facts(TomlReader& reader, const toml::table& table, std::vector<GivenFact>& facts) {
    for (const auto& [key, value] : table) {
        GivenFact fact;
        fact.predicate = std::string(key.str());
        if (!value.is_array()) {
            read_item(reader, value, fact, facts);
            continue;
        }
        for (const toml::node& item : *value.as_array()) read_item(reader, item, fact, facts);
    }
}

void read_settings(TomlReader& reader, const toml::table& table, std::map<std::string, std::string>& set) {
    for (const auto& [key, value] : table) set[std::string(key.str())] = literal(reader, value, fmt::format("[set] {}", key.str()));
}

}  // namespace meld::world
