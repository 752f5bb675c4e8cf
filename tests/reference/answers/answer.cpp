#include "tests/reference/answers/answer.h"

#include <nlohmann/json.hpp>

namespace meld::reference {

namespace {

using Json = nlohmann::ordered_json;

template <class T>
std::optional<T> maybe(const Json& from, const char* key) {
    return from.contains(key) ? std::optional(from.at(key).get<T>()) : std::nullopt;
}

Answer::Part read_part(const Json& from) {
    return {.is = from.at("is"),
            .text = from.at("text"),
            .note = from.value("note", ""),
            .node = maybe<std::size_t>(from, "node"),
            .tick = maybe<std::int64_t>(from, "tick")};
}

Answer::Way read_way(const Json& from) {
    Answer::Way out{.rule = from.value("rule", ""),
                    .text = from.value("text", ""),
                    .file = from.value("file", ""),
                    .note = from.value("note", ""),
                    .line = from.value("line", std::int64_t{0}),
                    .catom = from.value("catom", std::int64_t{-1}),
                    .with = from.value("with", std::map<std::string, std::string>{}),
                    .parts = {}};
    for (const Json& part : from.at("parts")) out.parts.push_back(read_part(part));
    return out;
}

Answer::Node read_node(const Json& from) {
    Answer::Node out{.fact = from.at("fact"),
                     .is = from.at("is"),
                     .note = from.value("note", ""),
                     .tick = from.at("tick"),
                     .rank = maybe<std::uint64_t>(from, "rank"),
                     .ways = {},
                     .more = from.value("more", std::uint64_t{0}),
                     .others = from.value("others", std::vector<std::string>{})};
    for (const Json& way : from.at("ways")) out.ways.push_back(read_way(way));
    return out;
}

}  // namespace

Answer read_answer(const Json& json) {
    Answer out{.tick = json.at("tick"), .roots = json.at("roots"), .nodes = {}, .more = json.value("more", std::uint64_t{0})};
    for (const Json& node : json.at("nodes")) out.nodes.push_back(read_node(node));
    return out;
}

}  // namespace meld::reference
