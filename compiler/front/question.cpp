#include "compiler/front/question.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "compiler/front/body.h"
#include "runtime/abi/question.h"

namespace meld::front {

namespace {

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

}  // namespace

Result<void> add_question(source::FileSet& files, const std::string& body, diagnostics::Reporter& report, syntax::Tree& program) {
    Result<std::optional<syntax::Rule>> parsed = parse_body(files, body, report);
    if (!parsed) return tl::unexpected<Error>(parsed.error());
    if (!*parsed) return {};
    syntax::Rule& rule = **parsed;
    std::optional<syntax::Expr> catom = catom_of(rule);
    if (!catom)
        return fail(fmt::format("'{}' has no fact of a catom, so it holds nowhere", body),
                    "Write what stands behind :- in a rule, without a full stop: 'dist(A, D), D > 3'");
    if (const syntax::Atom* linear = linear_fact(rule.body, program))
        return fail(fmt::format("'{}' asks about a linear fact, {}, which rules consume within the tick", body, linear->name.text),
                    "Ask about a fact that stays, such as one that the rule which consumes it makes");
    const source::Span span = rule.span;
    syntax::Declaration declaration{
        .modifiers = {}, .name = {std::string(kQuestion), span}, .arguments = {}, .repeats = false, .span = span};
    declaration.arguments.emplace_back().type = {.name = "node", .arguments = {}, .span = span};
    syntax::Atom head{.sigil = {}, .name = {std::string(kQuestion), span}, .arguments = {}, .span = span};
    head.arguments.push_back(std::make_unique<syntax::Expr>(std::move(*catom)));
    rule.arrow = syntax::Arrow::View;
    rule.head.push_back({syntax::HeadFact{std::move(head), {}}, span});
    program.add(std::move(declaration), 0);
    program.add(std::move(rule), 0);
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
        const std::vector<check::VariableId> bound = answers(rule);
        for (const check::VariableId variable : bound) {
            const check::Type type = rule.variables[variable].type;
            question.arguments.push_back({type, rule.variables[variable].name});
            head.arguments.push_back({.op = check::Op::Variable, .type = type, .span = rule.span, .variable = variable});
        }
        if (bound.empty()) continue;
        question.aggregate = check::Aggregate::First;
        question.aggregate_at = 1;
    }
}

}  // namespace meld::front
