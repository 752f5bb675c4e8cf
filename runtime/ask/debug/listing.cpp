#include "runtime/ask/debug/listing.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/ask/facts/program.h"
#include "runtime/base/did_you_mean.h"

namespace meld::debug {

namespace {

// Rules and predicates of the prelude stand in its file, which is the first.
constexpr std::uint32_t kPrelude = 0;

bool derives(const check::Program& program, const check::Rule& rule, const std::string& predicate) {
    return std::ranges::any_of(rule.derives, [&](check::PredicateId id) { return program.predicates[id].name == predicate; });
}

}  // namespace

Result<RulesListed> list_rules(const ModuleInfo& module, const std::string& predicate) {
    const Result<inspect::Program> read = inspect::Program::read(module, std::string());
    if (!read) return tl::unexpected<Error>(read.error());
    const check::Program& program = read->checked();
    const auto named = [&](const check::Predicate& p) { return p.name == predicate; };
    if (!predicate.empty() && std::ranges::none_of(program.predicates, named)) {
        std::vector<std::string_view> known;
        for (const check::Predicate& p : program.predicates) known.push_back(p.name);
        const auto near = nearest_name(predicate, known);
        return fail(fmt::format("the program has no predicate '{}'", predicate), near ? fmt::format("Did you mean '{}'?", *near) : "");
    }
    RulesListed out;
    for (const check::Rule& rule : program.rules) {
        if (rule.span.file == kPrelude || (!predicate.empty() && !derives(program, rule, predicate))) continue;
        const source::File& file = read->files().file(rule.span);
        out.rules.push_back({.name = rule.name,
                             .text = rule.text,
                             .file = file.path(),
                             .library = !file.on_disk(),
                             .line = rule.line,
                             .last_line = read->files().end(rule.span).line});
    }
    return out;
}

Result<PredicatesListed> list_predicates(const ModuleInfo& module) {
    const Result<inspect::Program> read = inspect::Program::read(module, std::string());
    if (!read) return tl::unexpected<Error>(read.error());
    PredicatesListed out;
    for (const check::Predicate& p : read->checked().predicates)
        out.predicates.push_back(
            {.name = p.name, .declaration = std::string(read->files().text(p.declaration)), .own = p.declaration.file != kPrelude});
    std::ranges::stable_sort(out.predicates, {}, &PredicatesListed::Predicate::name);
    return out;
}

}  // namespace meld::debug
