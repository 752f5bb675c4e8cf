#include "runtime/ask/dap/rules.h"

#include <algorithm>
#include <filesystem>

namespace meld::dap {

namespace {

namespace fs = std::filesystem;

// As the client and the run may write it differently: links are followed, and it need not exist.
std::string normal(const fs::path& path) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(path, error);
    return (error ? path.lexically_normal() : real).string();
}

bool ends_with(const fs::path& path, const fs::path& end) {
    auto at = path.end(), of_end = end.end();
    while (of_end != end.begin()) {
        if (at == path.begin() || *--at != *--of_end) return false;
    }
    return true;
}

// "dist@12" is the rule at line 12 whose head is dist.
std::string_view derived_predicate(std::string_view name) { return name.substr(0, name.rfind('@')); }

}  // namespace

Rules::Rules(const Json& answer, const std::string& folder) {
    for (const Json& each : answer.at("rules")) {
        Rule rule{.name = each.at("name").get<std::string>(),
                  .text = each.at("text").get<std::string>(),
                  .file = each.at("file").get<std::string>(),
                  .library = each.at("library").get<bool>(),
                  .line = each.at("line").get<std::int64_t>(),
                  .last_line = each.at("last_line").get<std::int64_t>()};
        if (!rule.library && !folder.empty()) rule.path = normal(fs::path(folder) / rule.file);
        rules_.push_back(std::move(rule));
    }
}

std::vector<const Rule*> Rules::of_file(const std::string& path) {
    const std::string wanted = normal(path);
    std::vector<const Rule*> found;
    for (Rule& rule : rules_) {
        if (rule.path.empty() && !rule.library && ends_with(wanted, fs::path(rule.file).lexically_normal())) rule.path = wanted;
        if (rule.path == wanted) found.push_back(&rule);
    }
    std::ranges::stable_sort(found, {}, &Rule::line);
    return found;
}

const Rule* Rules::named(const std::string& name) const {
    const auto found = std::ranges::find(rules_, name, &Rule::name);
    return found == rules_.end() ? nullptr : &*found;
}

bool Rules::derive(const std::string& predicate) const {
    return std::ranges::any_of(rules_, [&](const Rule& rule) { return derived_predicate(rule.name) == predicate; });
}

const Rule* rule_at(const std::vector<const Rule*>& rules, std::int64_t line) {
    const auto found = std::ranges::find_if(rules, [&](const Rule* rule) { return rule->last_line >= line; });
    return found == rules.end() ? nullptr : *found;
}

Json source_of(const Rule& rule) {
    if (rule.path.empty()) return nullptr;
    return {{"name", fs::path(rule.path).filename().string()}, {"path", rule.path}};
}

}  // namespace meld::dap
