#include "runtime/ask/debug/breaks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <string_view>
#include <utility>

#include "runtime/ask/debug/rule_text.h"
#include "runtime/ask/facts/program.h"
#include "runtime/base/did_you_mean.h"

namespace meld::debug {

namespace {

using check::Rule;
using inspect::Program;
using Verb = front::WatchRule::Verb;

// What stands between the arrow and the full stop of a rule as Meld prints it; nothing: it has no body.
std::optional<std::string> body_of(std::string_view text) {
    const std::size_t arrow = find_outside_strings(text, ":-");
    if (arrow == std::string_view::npos) return std::nullopt;
    std::string_view body = text.substr(arrow + 2);
    if (body.ends_with('.')) body.remove_suffix(1);
    body.remove_prefix(std::min(body.find_first_not_of(' '), body.size()));
    return std::string(body);
}

// A rule that somebody has written, and its lines.
struct WrittenRule {
    const Rule* rule;
    std::uint32_t first, last;
};

std::string_view name_of(std::string_view path) { return path.substr(path.rfind('/') + 1); }

// Not those of the compiler's own libraries.
std::vector<WrittenRule> written_rules(const Program& program) {
    std::set<std::string_view> own;
    for (u32 i = 0; i < program.module().source_count; ++i) own.insert(name_of(program.module().sources[i].path));
    std::vector<WrittenRule> out;
    for (const Rule& rule : program.checked().rules) {
        if (rule.text.empty() || rule.line == 0 || rule.arrives || !own.contains(rule.file)) continue;
        out.push_back({&rule, rule.line, std::max(rule.line, program.files().end(rule.span).line)});
    }
    return out;
}

std::string place_of(const Rule& rule) { return fmt::format("{}:{}", rule.file, rule.line); }

// 12 is a line of the program's own file.
Result<std::vector<const Rule*>> rules_at(const Program& program, const std::vector<WrittenRule>& all, std::string_view file,
                                          std::uint32_t line) {
    const std::string name(file.empty() ? name_of(program.module().sources[0].path) : file);
    std::vector<const Rule*> found;
    const WrittenRule* next = nullptr;
    bool known = false;
    for (const WrittenRule& one : all) {
        if (one.rule->file != name) continue;
        known = true;
        if (one.first <= line && line <= one.last) found.push_back(one.rule);
        if (one.first > line && (next == nullptr || one.first < next->first)) next = &one;
    }
    if (!found.empty()) return found;
    if (!known) return fail(fmt::format("break: there are no rules in a file {}", name), "");
    return fail(fmt::format("break: no rule is in line {} of {}", line, name),
                next != nullptr ? fmt::format("The next one begins in line {}", next->first) : "");
}

Result<std::vector<const Rule*>> find_rules(const Program& program, const std::string& asked) {
    const std::vector<WrittenRule> all = written_rules(program);
    const std::size_t colon = asked.rfind(':');
    const std::string_view digits = std::string_view(asked).substr(colon == std::string::npos ? 0 : colon + 1);
    std::uint32_t line = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), line);
    if (!digits.empty() && error == std::errc{} && end == digits.data() + digits.size())
        return rules_at(program, all, colon == std::string::npos ? "" : std::string_view(asked).substr(0, colon), line);
    std::vector<const Rule*> found;
    std::set<std::string> names;
    for (const WrittenRule& one : all)
        for (const check::PredicateId id : one.rule->derives) {
            const std::string& head = program.checked().predicates[id].name;
            names.insert(head);
            if ((asked == head || asked == one.rule->name) && (found.empty() || found.back() != one.rule)) found.push_back(one.rule);
        }
    if (!found.empty()) return found;
    const std::vector<std::string_view> known(names.begin(), names.end());
    const auto near = nearest_name(asked, known);
    return fail(fmt::format("break: no rule has a head '{}'", asked),
                near ? fmt::format("Did you mean '{}'?", *near) : fmt::format("Rules have the heads {}", fmt::join(known, ", ")));
}

}  // namespace

front::WatchRule rule_of(const std::string& body, Verb verb) {
    return {.verb = verb, .name = "", .shown = {}, .asked = {.text = body}, .body = body};
}

Result<Answer> BreakList::add(const ModuleInfo& module, const Break& asked) {
    const Result<Program> program = Program::read(module, "");
    if (!program) return tl::unexpected<Error>(program.error());
    const Result<std::vector<const Rule*>> rules = find_rules(*program, asked.rule);
    if (!rules) return tl::unexpected<Error>(rules.error());
    Entry entry{.asked = asked, .shown = {.rule = true, .what = asked.rule + (asked.condition.empty() ? "" : " if " + asked.condition)}};
    for (const Rule* rule : *rules) {
        if (rule->linear && !rule->initial_fact) {
            Result<LinearBreak> linear = linear_break(module, *rule, asked.condition);
            if (!linear) return tl::unexpected<Error>(linear.error());
            entry.linear.push_back(std::move(*linear));
            entry.shown.rules.push_back(fmt::format("{}: {}", place_of(*rule), rule->text));
            continue;
        }
        const std::optional<std::string> body = body_of(rule->text);
        if (!body && rules->size() > 1) continue;
        if (!body) return fail(fmt::format("break: the rule in {} has no body, so it holds from the start", place_of(*rule)), "");
        front::WatchRule watched = rule_of(*body + (asked.condition.empty() ? "" : ", " + asked.condition), Verb::Stop);
        watched.name = place_of(*rule);
        entry.rules.push_back(std::move(watched));
        entry.shown.rules.push_back(fmt::format("{}: {}", place_of(*rule), rule->text));
    }
    if (entry.rules.empty() && entry.linear.empty())
        return fail(fmt::format("break: none of the rules of {} has a body, so they hold from the start", asked.rule), "");
    return add(module, std::move(entry));
}

Result<Answer> BreakList::add(const ModuleInfo& module, const Watch& asked) {
    return add(module, Entry{.asked = asked, .shown = {.what = asked.body}, .rules = {rule_of(asked.body, Verb::Stop)}});
}

// Mistakes are told now, and not on the way.
Result<Answer> BreakList::add(const ModuleInfo& module, Entry entry) {
    for (const front::WatchRule& rule : entry.rules)
        if (auto can = inspect::Watch::make(module, rule); !can) return tl::unexpected<Error>(can.error());
    module_ = &module;
    entry.shown.number = ++last_number_;
    entries_.push_back(std::move(entry));
    watches_.reset();
    return BreaksFound{.breaks = {entries_.back().shown}};
}

Result<Answer> BreakList::remove(std::optional<std::uint64_t> number) {
    if (std::erase_if(entries_, [&](const Entry& e) { return !number || e.shown.number == *number; }) == 0 && number)
        return fail(fmt::format("delete: there is no break or watch with the number {}", *number), "`breaks` lists them");
    watches_.reset();
    return all();
}

std::vector<BreaksFound::One> BreakList::reread(const ModuleInfo& module) {
    std::vector<BreaksFound::One> lost;
    const std::uint64_t last = last_number_;
    module_ = &module;
    watches_.reset();
    for (const Entry& e : std::exchange(entries_, {})) {
        last_number_ = e.shown.number - 1;
        if (!std::visit([&](const auto& asked) { return add(module, asked); }, e.asked)) lost.push_back(e.shown);
    }
    last_number_ = last;
    return lost;
}

BreaksFound BreakList::all() const {
    BreaksFound found;
    for (const Entry& e : entries_) found.breaks.push_back(e.shown);
    return found;
}

Result<void> BreakList::begin(sim::Subdomain& subdomain) {
    tell_firings(subdomain);
    if (entries_.empty() || watches_) return {};
    std::vector<front::WatchRule> rules;
    for (const Entry& e : entries_) rules.insert(rules.end(), e.rules.begin(), e.rules.end());
    Result<std::unique_ptr<inspect::Watches>> made = inspect::Watches::make(*module_, std::move(rules), nullptr);
    if (!made) return tl::unexpected<Error>(made.error());
    watches_ = std::move(*made);
    return watches_->look(subdomain).map([](const auto&) {});
}

Result<std::vector<Stop>> BreakList::after(sim::Subdomain& subdomain) {
    std::vector<Stop> stops;
    if (entries_.empty()) return stops;
    const Result<inspect::Watches::Looked> looked = watches_->look(subdomain);
    if (!looked) return tl::unexpected<Error>(looked.error());
    for (const inspect::Watches::News& news : looked->news) {
        std::size_t first = 0;
        const auto of = std::ranges::find_if(entries_, [&](const Entry& e) { return news.watch < (first += e.rules.size()); });
        const front::WatchRule& rule = of->rules[news.watch - (first - of->rules.size())];
        const std::string what = of->shown.rule ? rule.name : of->shown.what;
        stops.push_back({.number = of->shown.number, .what = what, .ways = news.lines});
    }
    if (auto done = add_fired(subdomain, stops); !done) return tl::unexpected<Error>(done.error());
    std::ranges::stable_sort(stops, {}, &Stop::number);
    return stops;
}

// A run that was restored from a snapshot tells nothing until it is asked to.
void BreakList::tell_firings(sim::Subdomain& subdomain) const {
    std::vector<bool> told;
    for (const Entry& e : entries_)
        for (const LinearBreak& one : e.linear) {
            told.resize(module_->rule_count);
            told[one.rule] = true;
        }
    subdomain.tell_firings(std::move(told));
}

Result<void> BreakList::add_fired(sim::Subdomain& subdomain, std::vector<Stop>& stops) const {
    std::vector<LinearBreak> all;
    std::vector<const Entry*> of;
    for (const Entry& e : entries_)
        for (const LinearBreak& one : e.linear) {
            all.push_back(one);
            of.push_back(&e);
        }
    if (all.empty()) return {};
    Result<std::vector<Fired>> found = fired(subdomain, all);
    if (!found) return tl::unexpected<Error>(found.error());
    for (std::size_t i = 0; i < all.size(); ++i) {
        Fired& one = (*found)[i];
        if (one.at.empty()) continue;
        stops.push_back({.number = of[i]->shown.number, .what = all[i].place, .ways = std::move(one.ways), .at = std::move(one.at)});
    }
    return {};
}

}  // namespace meld::debug
