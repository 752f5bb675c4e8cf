// JSON from outside that does not nest deeply. Whoever copies, prints or goes through nested JSON calls itself, so how deep it may be is
// limited while it is read.
#pragma once

#include <optional>
#include <string_view>

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

}  // namespace meld
