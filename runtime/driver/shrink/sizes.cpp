#include "runtime/driver/shrink/sizes.h"

#include <cctype>
#include <string>
#include <string_view>

#include "runtime/base/units.h"

namespace meld::driver {

namespace {

struct Number {
    std::size_t begin = 0, end = 0;
    std::int64_t value = 0;
};

// Whole numbers that stand for themselves: not 0.5, and not in the name of a file.
std::vector<Number> numbers_of(const std::string& text) {
    const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.'; };
    std::vector<Number> all;
    bool quoted = false;
    for (std::size_t at = 0; at < text.size();) {
        quoted = text[at] == '\'' ? !quoted : quoted;
        std::size_t end = at;
        while (end < text.size() && is_word(text[end])) ++end;
        if (end == at) {
            ++at;
            continue;
        }
        const bool number = std::isdigit(static_cast<unsigned char>(text[at])) != 0 && !quoted;
        if (const auto count = parse_count(std::string_view(text).substr(at, end - at));
            number && text.find('.', at) >= end && count && *count < (std::uint64_t{1} << 40))
            all.push_back({at, end, static_cast<std::int64_t>(*count)});
        at = end;
    }
    return all;
}

template <class Table>
auto* sized_table(Table& keys, const SizePlace& place) {
    if (!place.body) return &keys;
    auto* body = keys.get("body");
    return body->is_table() ? body->as_table() : body->as_array()->get(*place.body)->as_table();
}

const char* key_of(const SizePlace& place) { return place.body ? "shape" : "graph"; }

std::string text_at(const toml::table& keys, const SizePlace& place) {
    const toml::table* table = sized_table(keys, place);
    return table == nullptr ? "" : (*table)[key_of(place)].value_or(std::string());
}

}  // namespace

std::vector<SizePlace> sizes_in(const toml::table& keys) {
    std::vector<SizePlace> all;
    const auto add = [&](std::optional<std::size_t> body) {
        const std::vector<Number> numbers = numbers_of(text_at(keys, {body}));
        for (std::size_t i = 0; i < numbers.size(); ++i)
            if (numbers[i].value >= 2) all.push_back({body, i});
    };
    add(std::nullopt);
    const toml::node* body = keys.get("body");
    if (body != nullptr && body->is_table()) add(0);
    for (std::size_t i = 0; body != nullptr && body->is_array() && i < body->as_array()->size(); ++i) add(i);
    return all;
}

std::int64_t size_at(const toml::table& keys, const SizePlace& place) { return numbers_of(text_at(keys, place)).at(place.number).value; }

void set_size(toml::table& keys, const SizePlace& place, std::int64_t value) {
    std::string text = text_at(keys, place);
    const Number number = numbers_of(text).at(place.number);
    text.replace(number.begin, number.end - number.begin, std::to_string(value));
    sized_table(keys, place)->insert_or_assign(key_of(place), text);
}

}  // namespace meld::driver
