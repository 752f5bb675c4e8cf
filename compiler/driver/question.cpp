#include "compiler/driver/question.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "compiler/syntax/parse.h"
#include "runtime/abi/question.h"

namespace meld::driver {

namespace {

constexpr std::string_view kRestOfRule = "\n-o 1.";

// Nobody has typed the rest of the rule: where it should not begin, the body should not end.
diagnostics::Diagnostic within(const std::string& body, diagnostics::Diagnostic mistake) {
    const auto end = static_cast<std::uint32_t>(body.size());
    if (mistake.span.begin < end) return mistake;
    mistake.span = {mistake.span.file, end == 0 ? 0 : end - 1, end};
    const std::string_view arrow = "`-o`";
    if (const std::size_t at = mistake.message.find(arrow); at != std::string::npos)
        mistake.message.replace(at, arrow.size(), "the end of the body");
    return mistake;
}

// The catom in the first fact of the body.
std::optional<syntax::Expr> catom_of(const syntax::Rule& rule) {
    for (const syntax::Clause& clause : rule.body) {
        const auto* atom = std::get_if<syntax::Atom>(&clause.node);
        if (atom == nullptr || atom->arguments.empty()) continue;
        const syntax::Expr& first = *atom->arguments[0];
        if (const auto* variable = std::get_if<syntax::Variable>(&first.node)) return syntax::Expr{*variable, first.span};
        if (const auto* catom = std::get_if<syntax::CatomLiteral>(&first.node)) return syntax::Expr{*catom, first.span};
    }
    return std::nullopt;
}

// The first fact of the body, also within its parts, that is linear. A question is no rule that could consume it.
const syntax::Atom* linear_fact(const std::vector<syntax::Clause>& body, const syntax::Tree& program) {
    const auto is_linear = [&](const syntax::Atom& atom) {
        return std::ranges::any_of(program.items, [&](const syntax::Item& item) {
            const auto* d = std::get_if<syntax::Declaration>(&item);
            return d != nullptr && d->name.text == atom.name.text && d->arguments.size() == atom.arguments.size() &&
                   std::ranges::any_of(d->modifiers, [](const syntax::Name& m) { return m.text == "linear"; });
        });
    };
    for (const syntax::Clause& clause : body) {
        const syntax::Atom* found = nullptr;
        if (const auto* atom = std::get_if<syntax::Atom>(&clause.node); atom != nullptr && is_linear(*atom)) found = atom;
        if (const auto* none = std::get_if<syntax::Not>(&clause.node)) found = linear_fact(none->clauses, program);
        if (const auto* aggregate = std::get_if<syntax::BodyAggregate>(&clause.node)) found = linear_fact(aggregate->clauses, program);
        if (found != nullptr) return found;
    }
    return nullptr;
}

// The variables that every way to satisfy the body gives a value, in the order in which they occur.
class Bound {
  public:
    explicit Bound(const check::Rule& rule) : rule_(rule) {
        for (const check::Clause& c : rule.body) {
            using Kind = check::Clause::Kind;
            if (c.kind == Kind::Atom) std::ranges::for_each(c.atom.arguments, [&](const check::Term& t) { add(t); });
            if (c.kind == Kind::Test && c.test.op == check::Op::Equal)
                std::ranges::for_each(c.test.operands, [&](const auto& t) { add(t); });
            if (c.kind == Kind::Element || c.kind == Kind::Aggregate) add(c.variable);
        }
    }
    const std::vector<check::VariableId>& variables() const { return variables_; }

  private:
    void add(const check::Term& term) {
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

Result<void> add_question(source::FileSet& files, const std::string& body, diagnostics::Reporter& report, syntax::Tree& program) {
    const auto wrong = [&](const std::string& why) {
        return fail(fmt::format("'{}' {}", body, why), "Write what stands behind :- in a rule, without a full stop: 'dist(A, D), D > 3'");
    };
    // A body comes first in a rule that consumes facts, so places in it are those in what was typed.
    const std::uint32_t file = files.add("the body", body + std::string(kRestOfRule));
    diagnostics::Reporter mistakes;
    syntax::Tree tree = syntax::parse(files, file, mistakes, {.follow_includes = false});
    for (diagnostics::Diagnostic& mistake : mistakes.sorted()) report.add(within(body, std::move(mistake)));
    if (mistakes.has_errors()) return {};
    auto* rule = tree.items.size() == 1 ? std::get_if<syntax::Rule>(tree.items.data()) : nullptr;
    if (rule == nullptr || rule->arrow != syntax::Arrow::Linear || rule->selector || rule->body.empty()) return wrong("is not one body");
    std::optional<syntax::Expr> catom = catom_of(*rule);
    if (!catom) return wrong("has no fact of a catom, so it holds nowhere");
    if (const syntax::Atom* linear = linear_fact(rule->body, program))
        return fail(fmt::format("'{}' asks about a linear fact, {}, which rules consume within the tick", body, linear->name.text),
                    "Ask about a fact that stays, such as one that the rule which consumes it makes");
    const source::Span span = {file, 0, static_cast<std::uint32_t>(body.size())};
    rule->span = span;
    syntax::Declaration declaration{
        .modifiers = {}, .name = {std::string(kQuestion), span}, .arguments = {}, .repeats = false, .span = span};
    declaration.arguments.emplace_back().type = {.name = "node", .arguments = {}, .span = span};
    syntax::Atom head{.sigil = {}, .name = {std::string(kQuestion), span}, .arguments = {}, .span = span};
    head.arguments.push_back(std::make_unique<syntax::Expr>(std::move(*catom)));
    rule->arrow = syntax::Arrow::View;
    rule->head.clear();
    rule->head.push_back({syntax::HeadFact{std::move(head), {}}, span});
    program.add(std::move(declaration), 0);
    program.add(std::move(tree.items[0]), 0);
    return {};
}

void add_witness(check::Program& program) {
    for (const check::RuleId id : program.rules.ids()) {
        check::Rule& rule = program.rules[id];
        if (rule.linear || rule.heads.empty() || rule.refused) continue;
        check::Atom& head = rule.heads[0].atom;
        check::Predicate& question = program.predicates[head.predicate];
        if (question.name != kQuestion) continue;
        rule.used_once.clear();
        const Bound bound(rule);
        for (const check::VariableId variable : bound.variables()) {
            const check::Type type = rule.variables[variable].type;
            question.arguments.push_back({type, rule.variables[variable].name});
            head.arguments.push_back({.op = check::Op::Variable, .type = type, .span = rule.span, .variable = variable});
        }
        if (bound.variables().empty()) continue;
        question.aggregate = check::Aggregate::First;
        question.aggregate_at = 1;
    }
}

}  // namespace meld::driver
