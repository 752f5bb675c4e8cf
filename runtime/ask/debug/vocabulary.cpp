#include "runtime/ask/debug/vocabulary.h"

#include <fmt/format.h>

#include <string_view>

#include "runtime/ask/debug/listing.h"

namespace meld::debug {

namespace {

std::string_view file_name(std::string_view path) { return path.substr(path.rfind('/') + 1); }

}  // namespace

Vocabulary vocabulary_of(const sim::Subdomain& subdomain, const std::string& folder) {
    Vocabulary known{.folder = folder};
    if (const auto listed = list_predicates(subdomain.module))
        for (const auto& predicate : listed->predicates) known.predicates.push_back(predicate.name);
    if (const auto listed = list_rules(subdomain.module, ""))
        for (const RulesListed::Rule& rule : listed->rules) {
            const std::string head = rule.name.substr(0, rule.name.find('@'));
            known.heads.push_back(head);
            if (rule.library) continue;
            known.rules.push_back(head);
            known.rules.push_back(fmt::format("{}:{}", file_name(rule.file), rule.line));
            if (file_name(rule.file) == file_name(subdomain.module.sources[0].path)) known.lines.push_back(std::to_string(rule.line));
        }
    known.catoms = [&subdomain](std::string_view digits) {
        return catoms_that_begin(digits, subdomain.next_id(), [&](std::uint64_t id) {
            const auto catom = subdomain.ensemble.find(id);
            return catom && subdomain.owned(*catom);
        });
    };
    return known;
}

}  // namespace meld::debug
