// What a client asks while the run stands: breakpoints, the stack, values, expressions and commands.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <limits>
#include <sstream>

#include "runtime/ask/dap/adapter.h"
#include "runtime/ask/dap/text.h"
#include "runtime/base/shallow_json.h"

namespace meld::dap {

namespace {

constexpr std::array<std::string_view, 5> kMoves = {"step", "back", "to", "run", "until"};

std::string shown(const Json& answer) {
    std::string text = answer.value("text", "");
    while (text.ends_with('\n')) text.pop_back();
    return text;
}

// A line, a frame, a reference or how many there are: the protocol's numbers have 31 bits.
std::int64_t count(const Json& number) { return whole_number<std::int64_t>(number, 0, std::numeric_limits<std::int32_t>::max()); }
std::size_t count_or_none(const Json& arguments, const char* name) {
    return arguments.contains(name) ? static_cast<std::size_t>(count(arguments[name])) : 0;
}

}  // namespace

// ---- breakpoints

Adapter::Body Adapter::set_breakpoints(const Json& arguments) {
    Json asked = arguments.value("breakpoints", Json::array());
    for (Json& each : asked) each["line"] = count(each.at("line")) + 1 - first_line_;
    Body set = breakpoints_->set_lines(arguments.at("source").at("path").get<std::string>(), asked);
    if (!set) return set;
    for (Json& each : *set)
        for (const char* const key : {"line", "endLine"})
            if (each.contains(key)) each[key] = each[key].get<std::int64_t>() - 1 + first_line_;
    return Json{{"breakpoints", std::move(*set)}};
}

Adapter::Body Adapter::set_function_breakpoints(const Json& arguments) {
    Body set = breakpoints_->set_names(arguments.at("breakpoints"));
    if (!set) return set;
    return Json{{"breakpoints", std::move(*set)}};
}

Adapter::Body Adapter::set_exception_breakpoints(const Json&) { return Json(); }

Adapter::Body Adapter::breakpoint_locations(const Json& arguments) {
    const std::int64_t first = count(arguments.at("line")) + 1 - first_line_;
    const std::int64_t last = arguments.contains("endLine") ? count(arguments["endLine"]) + 1 - first_line_ : first;
    Json list = Json::array();
    for (const Rule* rule : rules_.of_file(arguments.at("source").at("path").get<std::string>()))
        if (rule->line <= last && rule->last_line >= first)
            list.push_back({{"line", rule->line - 1 + first_line_}, {"endLine", rule->last_line - 1 + first_line_}});
    return Json{{"breakpoints", std::move(list)}};
}

// ---- the stack and its values

Adapter::Body Adapter::stack_trace(const Json& arguments) {
    Body stack = place_->stack(count_or_none(arguments, "startFrame"), count_or_none(arguments, "levels"));
    if (!stack) return stack;
    for (Json& frame : stack->at("stackFrames"))
        for (const auto& [key, first] : {std::pair{"line", first_line_}, {"endLine", first_line_}, {"column", first_column_}})
            if (frame.contains(key) && frame[key] != 0) frame[key] = frame[key].get<std::int64_t>() - 1 + first;
    return stack;
}

Adapter::Body Adapter::scopes(const Json& arguments) { return place_->scopes(count(arguments.at("frameId"))); }

Adapter::Body Adapter::variables(const Json& arguments) {
    const Result<Variables> found = place_->variables(count(arguments.at("variablesReference")));
    if (!found) return tl::unexpected<Error>(found.error());
    return Json{{"variables", to_json(*found, count_or_none(arguments, "start"), count_or_none(arguments, "count"))}};
}

Adapter::Body Adapter::set_variable(const Json& arguments) {
    const Result<Variables> found = place_->variables(count(arguments.at("variablesReference")));
    if (!found) return tl::unexpected<Error>(found.error());
    const auto name = arguments.at("name").get<std::string>();
    const auto known = std::ranges::find(*found, name, &Variable::name);
    if (known == found->end()) return fail(fmt::format("there is no variable {}", name));
    if (!known->changeable) return fail(fmt::format("{} cannot be changed: it is what the run has come to", name));
    auto value = arguments.at("value").get<std::string>();
    if (!value.starts_with('@')) value = "@" + value;
    const std::string_view digits = catom_in(value);
    if (digits.empty()) return fail(fmt::format("'{}' is no catom", value), "Write a number, as @42");
    const Body chosen = choose(digits);
    if (!chosen) return chosen;
    return Json{{"value", value}};
}

// ---- the chosen catom

Adapter::Body Adapter::choose(std::string_view digits) {
    std::uint64_t catom = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), catom);
    if (error != std::errc{}) return fail(fmt::format("@{} is no catom", digits));
    const std::uint64_t before = place_->catom();
    place_->choose(catom);
    const Body facts = place_->facts();
    if (!facts) {
        place_->choose(before);
        return facts;
    }
    after_.push_back([this] { show_anew(); });
    return facts;
}

Adapter::Body Adapter::catom(const Json& arguments) {
    const auto number = whole_number<std::uint64_t>(arguments.at("catom"));
    const Body chosen = choose(std::to_string(number));
    if (!chosen) return chosen;
    return Json{{"catom", number}, {"facts", chosen->at("facts")}};
}

// ---- expressions and commands

Adapter::Body Adapter::evaluate(const Json& arguments) {
    const auto expression = arguments.at("expression").get<std::string>();
    const auto context = arguments.value("context", "watch");
    if (context == "repl") return typed(expression);
    return context == "hover" ? pointed_at(expression) : watched(expression);
}

// A line in the client's console: a command of the debugger, or a catom to look at.
Adapter::Body Adapter::typed(const std::string& line) {
    if (const std::string_view digits = catom_in(line); !digits.empty()) {
        const Body chosen = choose(digits);
        if (!chosen) return chosen;
        return Json{{"result", shown(*chosen)}, {"variablesReference", 0}};
    }
    const std::string_view first = first_word(line);
    if (std::ranges::find(kMoves, first) != kMoves.end()) {
        const Body moves = move({.command = line, .shown = true});
        if (!moves) return moves;
        after_.push_back([this] { client_.event("continued", {{"threadId", 1}, {"allThreadsContinued", true}}); });
        return Json{{"result", ""}, {"variablesReference", 0}};
    }
    if (first == "quit") {
        run_.end();
        return Json{{"result", ""}, {"variablesReference", 0}};
    }
    const Body answer = ask_line(run_, line);
    if (!answer) return answer;
    if (answer->value("reloaded", false)) {
        if (auto known = know_program(); !known) return tl::unexpected<Error>(known.error());
        after_.push_back([this] { show_anew(); });
    }
    std::int64_t reference = 0;
    if (answer->contains("columns") && answer->at("rows").size() > 1)
        reference = place_->table().add([this, rows = *answer] { return rows_of(rows, place_->table()); });
    if (answer->contains("why") && !answer->at("roots").empty()) {
        place_->explain(*answer);
        after_.push_back([this] { show_anew(); });
    }
    return Json{{"result", shown(*answer)}, {"variablesReference", reference}};
}

// A body, or a catom whose facts are to be seen.
Adapter::Body Adapter::watched(const std::string& expression) {
    const std::string_view digits = catom_in(expression);
    const Body answer = ask_line(run_, (digits.empty() ? "query " : "facts ") + expression);
    if (!answer) return answer;
    VariableTable& table = place_->table();
    if (!digits.empty()) {
        const std::int64_t reference =
            table.add([&table, facts = *answer]() -> Result<Variables> { return facts_by_predicate(facts, table); });
        return Json{{"result", fmt::format("{} facts", answer->at("count").dump())}, {"variablesReference", reference}};
    }
    Json out = {{"result", summary_of(*answer)}, {"variablesReference", 0}};
    if (!answer->at("columns").empty() && !answer->at("rows").empty())
        out["variablesReference"] = table.add([&table, rows = *answer]() -> Result<Variables> { return rows_of(rows, table); });
    return out;
}

// The name of a predicate: its facts at the chosen catom.
Adapter::Body Adapter::pointed_at(const std::string& word) {
    if (const auto known = know_words(); !known) return tl::unexpected<Error>(known.error());
    if (std::ranges::find(predicates_, word) == predicates_.end()) return fail(fmt::format("{} is no predicate", word));
    const Body answer = place_->facts(word);
    if (!answer) return answer;
    const Json& facts = answer->at("facts");
    if (facts.empty()) return Json{{"result", fmt::format("no {} at @{}", word, place_->catom())}, {"variablesReference", 0}};
    if (facts.size() == 1) return Json{{"result", facts[0]}, {"variablesReference", 0}};
    VariableTable& table = place_->table();
    return Json{{"result", fmt::format("{} facts", answer->at("count").dump())},
                {"variablesReference", table.add([&table, of = *answer]() -> Result<Variables> {
                     const Variables one = facts_by_predicate(of, table);
                     return table.list(one.at(0).reference);
                 })}};
}

// ---- completions

// The names of commands are the first words of the lines of `help`.
Result<void> Adapter::know_words() {
    if (!commands_.empty()) return {};
    const Body help = run_.ask("help"), predicates = help ? run_.ask("predicates") : help;
    if (!predicates) return tl::unexpected<Error>(predicates.error());
    std::istringstream lines(help->at("help").get<std::string>());
    for (std::string line; std::getline(lines, line);)
        if (const std::string_view word = first_word(line); !word.empty() && !line.starts_with(' ')) commands_.emplace_back(word);
    for (const Json& each : predicates->at("predicates"))
        if (const auto name = each.at("name").get<std::string>(); predicates_.empty() || predicates_.back() != name)
            predicates_.push_back(name);
    return {};
}

Adapter::Body Adapter::completions(const Json& arguments) {
    if (const auto known = know_words(); !known) return tl::unexpected<Error>(known.error());
    const auto text = arguments.at("text").get<std::string>();
    const std::int64_t column = count(arguments.at("column")) - first_column_;
    const std::size_t place = byte_offset(text, column < 0 ? 0 : static_cast<std::size_t>(column));
    const std::string_view word = word_before(text, place);
    const std::int64_t start = column + first_column_ - static_cast<std::int64_t>(word.size());
    Json targets = Json::array();
    const auto offer = [&](const std::vector<std::string>& names, const char* type) {
        for (const std::string& name : names)
            if (name.starts_with(word)) targets.push_back({{"label", name}, {"type", type}, {"start", start}, {"length", word.size()}});
    };
    if (first_word(std::string_view(text).substr(0, place)).size() == word.size()) offer(commands_, "keyword");
    if (!word.empty() || targets.empty()) offer(predicates_, "function");
    return Json{{"targets", std::move(targets)}};
}

}  // namespace meld::dap
