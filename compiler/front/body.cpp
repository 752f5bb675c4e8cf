#include "compiler/front/body.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <variant>

#include "compiler/syntax/parse.h"

namespace meld::front {

namespace {

constexpr std::string_view kRestOfRule = "\n-o 1.";

// Nobody has typed the rest of the rule: where it should not begin, the body should not end.
diagnostics::Diagnostic within(const std::string& body, diagnostics::Diagnostic mistake) {
    const auto end = static_cast<std::uint32_t>(body.size());
    std::erase_if(mistake.labels, [&](const diagnostics::Label& label) { return label.span.begin >= end; });
    if (mistake.span.begin < end) return mistake;
    mistake.span = {mistake.span.file, end == 0 ? 0 : end - 1, end};
    const std::string_view arrow = "`-o`";
    if (const std::size_t at = mistake.message.find(arrow); at != std::string::npos)
        mistake.message.replace(at, arrow.size(), "the end of the body");
    return mistake;
}

class Answers {
  public:
    explicit Answers(const check::Rule& rule) : rule_(rule) {
        for (const check::Clause& c : rule.body) {
            using Kind = check::Clause::Kind;
            if (c.kind == Kind::Atom) add(c.atom.arguments);
            if (c.kind == Kind::Test && c.test.op == check::Op::Equal) {
                add(c.test.operands);
                if (const check::TakeApart parts = check::taken_apart(c.test)) add(parts.constructor->operands);
            }
            if (c.kind == Kind::Element || c.kind == Kind::Aggregate) add(c.variable);
        }
    }
    std::vector<check::VariableId> take() { return std::move(variables_); }

  private:
    void add(const std::vector<check::Term>& terms) {
        for (const check::Term& term : terms)
            if (term.is_variable()) add(term.variable);
    }
    void add(check::VariableId id) {
        const check::Variable& v = rule_.variables[id];
        const bool named = !v.name.empty() && v.name[0] != '_' && v.name.find('@') == std::string::npos;
        const bool known = std::ranges::find(variables_, id) != variables_.end();
        if (named && !known && id != rule_.site && v.type != check::Type::Error) variables_.push_back(id);
    }
    const check::Rule& rule_;
    std::vector<check::VariableId> variables_;
};

}  // namespace

Result<std::optional<syntax::Rule>> parse_body(source::FileSet& files, const std::string& body, diagnostics::Reporter& report) {
    // A body comes first in a rule that consumes facts, so places in it are those in what was typed.
    const std::uint32_t file = files.add("the body", body + std::string(kRestOfRule));
    diagnostics::Reporter mistakes;
    syntax::Tree tree = syntax::parse(files, file, mistakes, {.follow_includes = false});
    const std::vector<diagnostics::Diagnostic> found = mistakes.sorted();
    // A rule that ends where the rest of ours begins has an arrow of its own.
    const bool ends =
        std::ranges::any_of(found, [](const diagnostics::Diagnostic& d) { return d.kind == diagnostics::Kind::MissingPeriod; });
    if (!ends) {
        for (const diagnostics::Diagnostic& mistake : found) report.add(within(body, mistake));
        if (mistakes.has_errors()) return std::nullopt;
    }
    auto* rule = tree.items.size() == 1 && tree.includes.empty() && !ends ? std::get_if<syntax::Rule>(tree.items.data()) : nullptr;
    if (rule == nullptr || rule->arrow != syntax::Arrow::Linear || rule->selector || rule->body.empty())
        return fail(fmt::format("'{}' is not one body", body),
                    "Write what stands behind :- in a rule, without a full stop: 'dist(A, D), D > 3'");
    rule->span = {file, 0, static_cast<std::uint32_t>(body.size())};
    rule->arrow = syntax::Arrow::Question;
    rule->head.clear();
    return std::move(*rule);
}

std::optional<std::vector<syntax::Rule>> parse_rules(source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report) {
    syntax::Tree tree = syntax::parse(files, file, report, {.follow_includes = false});
    if (report.has_errors()) return std::nullopt;
    const auto refuse = [&](source::Span span) {
        report.add(diagnostics::Kind::SyntaxError, span, "a file of watches has rules with `:-`, and nothing else").help =
            "declare and derive in the program what a watch reads";
    };
    for (const syntax::Tree::Include& include : tree.includes) refuse(include.where);
    std::vector<syntax::Rule> rules;
    for (syntax::Item& item : tree.items) {
        auto* rule = std::get_if<syntax::Rule>(&item);
        if (rule != nullptr && rule->arrow == syntax::Arrow::View && !rule->selector && !rule->body.empty()) {
            rules.push_back(std::move(*rule));
            continue;
        }
        refuse(std::visit([](const auto& any) { return any.span; }, item));
    }
    if (report.has_errors()) return std::nullopt;
    return rules;
}

std::vector<check::VariableId> answers(const check::Rule& rule) { return Answers(rule).take(); }

}  // namespace meld::front
