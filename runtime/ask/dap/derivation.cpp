#include "runtime/ask/dap/derivation.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>

namespace meld::dap {

namespace {

bool by_rule(const Json& node) { return !node.at("ways").empty() && node["ways"][0].contains("rule"); }

const Rule* rule_of(const Json& way, const Rules& rules) {
    for (const Rule& rule : rules.all())
        if (rule.name == way.at("rule").get<std::string>() && rule.line == way.at("line").get<std::int64_t>() &&
            std::filesystem::path(rule.file).filename() == way.at("file").get<std::string>())
            return &rule;
    return nullptr;
}

std::string note_of(const Json& json) { return json.contains("note") ? "  " + json["note"].get<std::string>() : ""; }

}  // namespace

std::vector<Derivation::Frame> Derivation::frames(const Rules& rules) const {
    std::vector<Frame> out;
    if (answer_.at("roots").empty()) return out;
    const Json& nodes = answer_.at("nodes");
    std::set<std::size_t> seen;
    for (auto at = answer_["roots"][0].get<std::size_t>(); by_rule(nodes.at(at)) && seen.insert(at).second;) {
        const Json& node = nodes[at];
        out.push_back({.fact = node.at("fact").get<std::string>(), .rule = rule_of(node["ways"][0], rules), .node = at});
        for (const Json& part : node["ways"][0].at("parts")) {
            if (part.at("is") != "fact" || !part.contains("node")) continue;
            const auto next = part["node"].get<std::size_t>();
            if (seen.contains(next) || !by_rule(nodes.at(next))) continue;
            at = next;
            break;
        }
    }
    return out;
}

Variables Derivation::rests_on(std::size_t number, VariableTable& table) const {
    const Json& node = answer_.at("nodes").at(number);
    const Json& ways = node.at("ways");
    Variables out;
    if (ways.size() == 1) {
        out = way(ways[0], table);
    } else {
        for (const Json& each : ways)
            out.push_back({.name = fmt::format("way {}", out.size() + 1),
                           .value = each.contains("text") ? each["text"].get<std::string>() : note_of(each),
                           .reference = table.add([this, &each, &table] { return way(each, table); })});
    }
    if (node.contains("others"))
        for (const Json& other : node["others"]) out.push_back({.name = "not", .value = other.get<std::string>()});
    if (node.contains("more")) out.push_back({.name = "...", .value = fmt::format("and {} more", node["more"].dump())});
    if (node.contains("note")) out.push_back({.name = "note", .value = node["note"].get<std::string>()});
    return out;
}

Variables Derivation::way(const Json& way, VariableTable& table) const {
    Variables out;
    if (way.contains("text"))
        out.push_back(
            {.name = "[rule]",
             .value = fmt::format("{}:{}: {}", way.at("file").get<std::string>(), way.at("line").dump(), way["text"].get<std::string>())});
    if (way.contains("note")) out.push_back({.name = "note", .value = way["note"].get<std::string>()});
    for (const Json& each : way.at("parts")) out.push_back(part(each, table));
    return out;
}

Variable Derivation::part(const Json& part, VariableTable& table) const {
    const auto text = part.at("text").get<std::string>();
    const auto is = part.at("is").get<std::string>();
    Variable out{.name = is == "fact" ? predicate_of(text) : is == "absent" ? "no" : is, .value = text + note_of(part)};
    if (part.contains("tick")) out.value += fmt::format("  in tick {}", part["tick"].dump());
    if (is == "fact") out.expression = text;
    if (!part.contains("node")) return out;
    const auto number = part["node"].get<std::size_t>();
    const Json& node = answer_.at("nodes").at(number);
    if (const auto kind = node.at("is").get<std::string>(); kind != "derived") out.value += "  " + kind;
    if (!node.at("ways").empty() || node.contains("note"))
        out.reference = table.add([this, number, &table] { return rests_on(number, table); });
    return out;
}

}  // namespace meld::dap
