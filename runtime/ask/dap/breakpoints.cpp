#include "runtime/ask/dap/breakpoints.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "runtime/ask/dap/text.h"

namespace meld::dap {

namespace {

std::string condition_of(const Json& asked) {
    const auto condition = asked.value("condition", "");
    return condition.empty() ? "" : " if " + condition;
}

}  // namespace

Result<void> Breakpoints::drop(std::vector<Set>& sets) {
    for (const Set& each : std::exchange(sets, {})) {
        const Result<Json> gone = run_.ask(fmt::format("delete {}", each.number));
        if (!gone && !run_.alive()) return tl::unexpected<Error>(gone.error());
    }
    return {};
}

// The breakpoint of a command of the session, as the protocol writes it.
Result<Json> Breakpoints::set(const std::string& command, std::vector<Set>& sets) {
    const std::int64_t id = ++last_id_;
    const Result<Json> made = ask_line(run_, command);
    if (!made && !run_.alive()) return tl::unexpected<Error>(made.error());
    if (!made) return Json{{"id", id}, {"verified", false}, {"message", made.error().message()}};
    sets.push_back({.id = id, .number = made->at("breaks").at(0).at("number").get<std::uint64_t>()});
    return Json{{"id", id}, {"verified", true}};
}

Result<Json> Breakpoints::set_lines(const std::string& path, const Json& asked) {
    std::vector<Set>& sets = by_file_[path];
    if (auto dropped = drop(sets); !dropped) return tl::unexpected<Error>(dropped.error());
    const std::vector<const Rule*> rules = rules_.of_file(path);
    Json out = Json::array();
    for (const Json& each : asked) {
        const Rule* const rule = rule_at(rules, each.at("line").get<std::int64_t>());
        if (rule == nullptr) {
            const std::string why =
                rules.empty() ? "the program of this run has no rules in this file" : "there is no rule at or after this line";
            out.push_back({{"id", ++last_id_}, {"verified", false}, {"message", why}});
            continue;
        }
        const std::string name = std::filesystem::path(rule->file).filename().string();
        Result<Json> made = set(fmt::format("break {}:{}{}", name, rule->line, condition_of(each)), sets);
        if (!made) return made;
        made->update({{"source", source_of(*rule)}, {"line", rule->line}, {"endLine", rule->last_line}});
        out.push_back(std::move(*made));
    }
    return out;
}

Result<Json> Breakpoints::set_names(const Json& asked) {
    if (auto dropped = drop(named_); !dropped) return tl::unexpected<Error>(dropped.error());
    Json out = Json::array();
    for (const Json& each : asked) {
        const auto name = each.at("name").get<std::string>();
        const bool body = name.find('(') != std::string::npos;
        const Result<Json> made = set(body ? "watch " + name : fmt::format("break {}{}", name, condition_of(each)), named_);
        if (!made) return made;
        out.push_back(*made);
    }
    return out;
}

Json Breakpoints::numbers_of(const Json& stops) const {
    Json out = Json::array();
    const auto look = [&](const std::vector<Set>& sets, const Json& number) {
        for (const Set& each : sets)
            if (number == each.number) out.push_back(each.id);
    };
    for (const Json& stop : stops) {
        for (const auto& [path, sets] : by_file_) look(sets, stop.at("number"));
        look(named_, stop.at("number"));
    }
    return out;
}

}  // namespace meld::dap
