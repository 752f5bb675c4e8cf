// JSON from outside. It does not nest deeply: whoever copies, prints or goes through nested JSON calls itself, so how deep it may be is
// limited while it is read. And its numbers may not fit what they are for, which the library does not say when it converts them.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace meld {

// The text as JSON of the library's type; discarded if it is none. None at all: it nests more than `most` levels deep.
template <class Json>
std::optional<Json> parse_shallow(std::string_view text, int most) {
    bool too_deep = false;
    const auto look = [&](int depth, typename Json::parse_event_t, Json&) {
        too_deep = too_deep || depth > most;
        return !too_deep;
    };
    Json json = Json::parse(text, look, false);
    if (too_deep) return std::nullopt;
    return json;
}

// The whole number from `least` to `most` that this is, if it is one.
template <class Int, class Json>
std::optional<Int> if_whole_number(const Json& json, Int least, Int most) {
    const auto fitting = [&](auto number) -> std::optional<Int> {
        if (!std::in_range<Int>(number) || static_cast<Int>(number) < least || static_cast<Int>(number) > most) return std::nullopt;
        return static_cast<Int>(number);
    };
    if (json.is_number_unsigned()) return fitting(json.template get<std::uint64_t>());
    if (json.is_number_integer()) return fitting(json.template get<std::int64_t>());
    return std::nullopt;
}

// The same, if it must be one. Throws what the library throws for a value of another type.
template <class Int, class Json>
Int whole_number(const Json& json, Int least = std::numeric_limits<Int>::min(), Int most = std::numeric_limits<Int>::max()) {
    if (const std::optional<Int> number = if_whole_number<Int>(json, least, most)) return *number;
    throw Json::type_error::create(302, "must be a whole number from " + std::to_string(least) + " to " + std::to_string(most), &json);
}

}  // namespace meld
