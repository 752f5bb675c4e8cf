// Places, types and ranges of the values in a TOML file.
#include "runtime/world/file/toml_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "runtime/base/did_you_mean.h"
#include "runtime/base/files/input_file.h"
#include "runtime/base/units.h"

namespace meld::world {
namespace {

std::string_view type_name(toml::node_type type) {
    switch (type) {
        case toml::node_type::table:
            return "a table";
        case toml::node_type::array:
            return "an array";
        case toml::node_type::string:
            return "a string";
        case toml::node_type::integer:
            return "an integer";
        case toml::node_type::floating_point:
            return "a number";
        case toml::node_type::boolean:
            return "true or false";
        default:
            return "a date or time";
    }
}

// The end of the string that begins at `at`: after its closing quotes, or at the end of the text.
std::size_t string_end(std::string_view text, std::size_t at) {
    const char quote = text[at];
    const bool lines = text.substr(at, 3) == std::string(3, quote);
    const std::string closing(lines ? 3 : 1, quote);
    for (std::size_t i = at + closing.size(); i < text.size(); ++i) {
        if (quote == '"' && text[i] == '\\') {
            ++i;
            continue;
        }
        if (text.substr(i, closing.size()) == closing) return i + closing.size();
        if (!lines && text[i] == '\n') return i;
    }
    return text.size();
}

}  // namespace

Result<void> check_key_depth(std::string_view text, const std::string& path) {
    constexpr std::size_t kMaxParts = 100;
    std::size_t dots = 0, line = 1, line_start = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '#') {
            i = std::min(text.find('\n', i), text.size()) - 1;
        } else if (c == '"' || c == '\'') {
            const std::size_t end = string_end(text, i);
            for (std::size_t k = i; k < end; ++k)
                if (text[k] == '\n') line_start = k + 1, ++line;
            i = end - 1;
        } else if (c == '.') {
            if (++dots < kMaxParts) continue;
            return fail(fmt::format("{}:{}:{}: this key has more than {} parts", path, line, i - line_start + 1, kMaxParts),
                        "No section of a world is deeper than [a.b]");
        } else if (c == '\n' || c == '=' || c == ',' || c == '[' || c == '{') {
            dots = 0;
            if (c == '\n') line_start = i + 1, ++line;
        }
    }
    return {};
}

std::string type_mismatch(const toml::node& node, std::string_view wanted) {
    return fmt::format("is {}, not {}", type_name(node.type()), wanted);
}

std::string TomlReader::place(const toml::source_region& source) const {
    return fmt::format("{}:{}:{}", path_, source.begin.line, source.begin.column);
}

std::string TomlReader::beside(const std::string& name) const { return (std::filesystem::path(path_).parent_path() / name).string(); }

Result<std::string> TomlReader::read_file(const std::string& path, std::uint64_t most_bytes) {
    files_read_.push_back(path);
    Result<std::string> text;
    if (files_ == nullptr)
        text = read_input(path, most_bytes);
    else if (const auto given = files_->find(path); given != files_->end())
        text = given->second;
    else
        return fail(path + " is missing");
    if (!text) return text;
    source_hash_ = hash_combine(source_hash_, hash_text(*text));
    files_hash_ = hash_combine(files_hash_, hash_text(*text));
    return text;
}

void TomlReader::wrong(Error error) {
    if (!error_) error_ = std::move(error);
}

void TomlReader::wrong(const toml::source_region& source, std::string_view problem, std::string suggestion) {
    wrong(Error{fmt::format("{}: {}", place(source), problem), std::move(suggestion)});
}

void TomlReader::wrong_in(const toml::node& string, const ExpressionError& error) {
    // Finding the place takes as long as the file is.
    if (error_) return;
    const toml::source_region& source = string.source();
    const std::string& value = **string.as_string();
    const std::string_view rest = line(source.begin.line);
    // The value is right after its quote unless it is escaped or has several lines.
    const std::size_t quote = source.begin.column;
    const bool plain = quote < rest.size() && rest.substr(quote).starts_with(value);
    if (!plain) return wrong(source, fmt::format("column {} of the text: {}", error.column, error.problem), error.suggestion);
    wrong(Error{fmt::format("{}:{}:{}: {}", path_, source.begin.line, quote + error.column, error.problem), error.suggestion});
}

std::string_view TomlReader::line(std::size_t number) const {
    std::string_view rest = text_;
    for (std::size_t i = 1; i < number; ++i) {
        const std::size_t end = rest.find('\n');
        if (end == std::string_view::npos) return {};
        rest.remove_prefix(end + 1);
    }
    return rest.substr(0, rest.find('\n'));
}

Section::Section(TomlReader& reader, const toml::table& table, std::string name, const std::vector<std::string_view>& known)
    : reader_(reader), table_(table), name_(std::move(name)) {
    // A table has its keys by name; the mistake to report is the first one in the file.
    std::vector<const toml::key*> unknown;
    for (const auto& [key, value] : table)
        if (std::find(known.begin(), known.end(), key.str()) == known.end()) unknown.push_back(&key);
    const auto line_of = [](const toml::key* key) { return std::pair(key->source().begin.line, key->source().begin.column); };
    std::ranges::sort(unknown, {}, line_of);
    const std::string where = name_.empty() ? "" : fmt::format(" in {}", name_);
    for (const toml::key* key : unknown)
        reader_.wrong(key->source(), fmt::format("there is no key '{}'{}", key->str(), where), did_you_mean(key->str(), known));
}

std::string Section::name_of(std::string_view key) const { return name_.empty() ? std::string(key) : fmt::format("{} {}", name_, key); }

void Section::read(std::string_view key, std::string& value) const {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_string()) return reader_.wrong(node->source(), fmt::format("{} {}", name_of(key), type_mismatch(*node, "a string")));
    value = **node->as_string();
}

void Section::read(std::string_view key, bool& value) const {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_boolean())
        return reader_.wrong(node->source(), fmt::format("{} {}", name_of(key), type_mismatch(*node, "true or false")));
    value = **node->as_boolean();
}

void Section::read(std::string_view key, std::vector<std::string>& value) const {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_array())
        return reader_.wrong(node->source(), fmt::format("{} {}", name_of(key), type_mismatch(*node, "an array of strings")));
    value.clear();
    for (const toml::node& item : *node->as_array()) {
        if (!item.is_string())
            return reader_.wrong(item.source(), fmt::format("an item of {} {}", name_of(key), type_mismatch(item, "a string")));
        value.push_back(**item.as_string());
    }
}

void Section::read_positive(std::string_view key, double& value) const {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_number()) return reader_.wrong(node->source(), fmt::format("{} {}", name_of(key), type_mismatch(*node, "a number")));
    const double number = *node->value<double>();
    if (!std::isfinite(number) || number <= 0) {
        return reader_.wrong(node->source(), fmt::format("{} = {} is not a number above zero", name_of(key), number));
    }
    value = number;
}

void Section::read_number(std::string_view key, double& value, double least, double most) const {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_number()) return reader_.wrong(node->source(), fmt::format("{} {}", name_of(key), type_mismatch(*node, "a number")));
    const double number = *node->value<double>();
    if (!std::isfinite(number)) return reader_.wrong(node->source(), fmt::format("{} = {} is not a finite number", name_of(key), number));
    if (number < least || number > most) {
        const bool open = most == std::numeric_limits<double>::max();
        return reader_.wrong(node->source(), open ? fmt::format("{} = {} is less than {}", name_of(key), number, least)
                                                  : fmt::format("{} = {} is not between {} and {}", name_of(key), number, least, most));
    }
    value = number;
}

bool Section::read_point(const toml::node& node, const std::string& what, Vec3& value) const {
    const toml::array* array = node.as_array();
    const bool fits = array != nullptr && array->size() == 3;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::optional<double> number = fits && array->get(i)->is_number() ? array->get(i)->value<double>() : std::nullopt;
        if (!number || !std::isfinite(*number)) {
            reader_.wrong(node.source(), what + " is not a point [x, y, z] of three finite numbers");
            return false;
        }
        value[i] = *number;
    }
    return true;
}

void Section::read(std::string_view key, Vec3& value) const {
    if (const toml::node* node = find(key)) read_point(*node, name_of(key), value);
}

void Section::read(std::string_view key, std::vector<Vec3>& value) const {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_array())
        return reader_.wrong(node->source(), fmt::format("{} {}", name_of(key), type_mismatch(*node, "an array of points [x, y, z]")));
    value.clear();
    for (const toml::node& item : *node->as_array()) {
        Vec3 point{};
        if (!read_point(item, "an item of " + name_of(key), point)) return;
        value.push_back(point);
    }
}

void Section::read_choice(std::string_view key, std::string& value, std::initializer_list<std::string_view> choices) const {
    std::string word = value;
    read(key, word);
    if (std::find(choices.begin(), choices.end(), word) == choices.end())
        return wrong(key, fmt::format("{} = \"{}\" does not exist", name_of(key), word),
                     did_you_mean(word, {choices.begin(), choices.size()}));
    value = word;
}

template <class T, class Text>
std::optional<T> Section::read_parsed(std::string_view key, Parsed<T> (*parse)(Text, Nameable)) const {
    const toml::node* node = find(key);
    if (!node) return std::nullopt;
    std::string text;
    read(key, text);
    if (!node->is_string()) return std::nullopt;
    Parsed<T> parsed = parse(text, reader_.nameable());
    if (parsed) return std::move(*parsed);
    reader_.wrong_in(*node, parsed.error());
    return std::nullopt;
}

std::optional<Region> Section::read_region(std::string_view key) const { return read_parsed(key, parse_region_text); }
std::optional<Shape> Section::read_shape(std::string_view key) const { return read_parsed(key, parse_shape_text); }

void Section::wrong(std::string_view key, std::string_view problem, std::string suggestion) const {
    const toml::node* node = find(key);
    reader_.wrong(node ? node->source() : table_.source(), problem, std::move(suggestion));
}

void Section::read_suffixed(std::string_view key, std::uint64_t& value, std::uint64_t least, std::uint64_t most,
                            Result<std::uint64_t> (*parse)(std::string_view)) const {
    const toml::node* node = find(key);
    if (!node) return;
    std::uint64_t number = 0;
    if (node->is_integer()) {
        const std::int64_t integer = **node->as_integer();
        if (integer < 0) return reader_.wrong(node->source(), fmt::format("{} = {} is below zero", name_of(key), integer));
        number = static_cast<std::uint64_t>(integer);
    } else if (node->is_string()) {
        const Result<std::uint64_t> parsed = parse(**node->as_string());
        if (!parsed)
            return reader_.wrong(node->source(), fmt::format("{}: {}", name_of(key), parsed.error().problem), parsed.error().suggestion);
        number = *parsed;
    } else {
        return reader_.wrong(node->source(),
                             fmt::format("{} {}", name_of(key), type_mismatch(*node, "a whole number, as 2000000 or \"2M\"")));
    }
    if (number < least || number > most) {
        return reader_.wrong(node->source(), fmt::format("{} = {} is not between {} and {}", name_of(key), number, least, most));
    }
    value = number;
}

void Section::read_count(std::string_view key, std::uint64_t& value, std::uint64_t least, std::uint64_t most) const {
    read_suffixed(key, value, least, most, parse_count);
}

void Section::read_count(std::string_view key, int& value, int least) const {
    auto wide = static_cast<std::uint64_t>(value);
    read_count(key, wide, static_cast<std::uint64_t>(least), std::numeric_limits<int>::max());
    value = static_cast<int>(wide);
}

void Section::read_bytes(std::string_view key, std::uint64_t& value) const {
    read_suffixed(key, value, 0, std::numeric_limits<std::uint64_t>::max(), parse_bytes);
}

void Section::read_seconds(std::string_view key, double& value) const {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_string()) return read_positive(key, value);
    const Result<double> parsed = parse_duration(**node->as_string());
    if (!parsed)
        return reader_.wrong(node->source(), fmt::format("{}: {}", name_of(key), parsed.error().problem), parsed.error().suggestion);
    if (*parsed <= 0) return reader_.wrong(node->source(), fmt::format("{} is not above zero", name_of(key)));
    value = *parsed;
}

}  // namespace meld::world
