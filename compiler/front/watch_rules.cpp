#include "compiler/front/watch_rules.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>
#include <utility>
#include <variant>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/front/body.h"
#include "compiler/source/source.h"
#include "compiler/syntax/tokens.h"
#include "compiler/syntax/tree.h"

namespace meld::front {

namespace {

using diagnostics::Kind;
using Verb = WatchRule::Verb;

constexpr std::pair<std::string_view, Verb> kVerbs[] = {
    {"stop", Verb::Stop}, {"tell", Verb::Tell}, {"expect", Verb::Expect}, {"never", Verb::Never}};

// What the head of a rule says: a name, and the variables that are told.
std::optional<WatchRule> read_head(const syntax::Rule& rule, diagnostics::Reporter& report) {
    const auto* head = rule.head.size() == 1 ? std::get_if<syntax::HeadFact>(&rule.head[0].node) : nullptr;
    const Verb* verb = nullptr;
    for (const auto& [name, known] : kVerbs)
        if (head != nullptr && !head->delay && head->atom.name.text == name) verb = &known;
    if (verb == nullptr) {
        report.add(Kind::SyntaxError, rule.head.empty() ? rule.span : rule.head[0].span, "this says nothing about what is watched").help =
            "begin with stop(...), tell(...), expect(...) or never(...)";
        return std::nullopt;
    }
    WatchRule out{.verb = *verb};
    for (std::size_t i = 0; i < head->atom.arguments.size(); ++i) {
        const syntax::Expr& e = *head->atom.arguments[i];
        const auto* text = std::get_if<syntax::StringLiteral>(&e.node);
        if (text != nullptr && i == 0) {
            out.name = text->value;
        } else if (const auto* variable = std::get_if<syntax::Variable>(&e.node)) {
            out.shown.push_back(variable->name);
        } else {
            report.add(Kind::SyntaxError, e.span, "the head of a watch names variables of its body, after a text if it has one").help =
                "give the value a name in the body: N = D + 1";
            return std::nullopt;
        }
    }
    return out;
}

// Without the comments and blanks of lines that go on.
std::string on_one_line(const source::FileSet& files, const std::vector<syntax::Token>& tokens, source::Span body) {
    std::string out;
    std::uint32_t end = body.begin;
    for (const syntax::Token& token : tokens) {
        if (token.span.begin < body.begin || token.span.end > body.end || token.span.begin == token.span.end) continue;
        if (token.span.begin != end) out += ' ';
        out += files.text(token.span);
        end = token.span.end;
    }
    return out;
}

}  // namespace

Result<std::vector<WatchRule>> read_watch_rules(const std::string& path, const std::string& text) {
    source::FileSet files;
    diagnostics::Reporter report;
    const std::uint32_t file = files.add(path, text);
    const std::optional<std::vector<syntax::Rule>> rules = parse_rules(files, file, report);
    diagnostics::Reporter again;
    const std::vector<syntax::Token> tokens = syntax::scan(files.file(file), file, again);
    std::vector<WatchRule> out;
    for (std::size_t i = 0; rules && i < rules->size(); ++i) {
        const syntax::Rule& rule = (*rules)[i];
        std::optional<WatchRule> read = read_head(rule, report);
        if (!read) continue;
        read->asked = {.text = text, .file = path, .rule = i};
        read->body = on_one_line(files, tokens, rule.body.front().span.to(rule.body.back().span));
        out.push_back(std::move(*read));
    }
    if (report.has_errors()) return fail(diagnostics::render_errors(files, report));
    if (out.empty()) return fail(fmt::format("{} has no rules", path), "Write what to watch: stop(A) :- leader(A).");
    return out;
}

}  // namespace meld::front
