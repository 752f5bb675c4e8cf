// Pass 2, priorities: heads and directives by which a program says which nodes go first, for clocks that give turns. Linear Meld leaves
// out the catom that asks, and orders priorities downwards or upwards; to the runtime the greatest is always first.
#include <fmt/format.h>

#include <cstdlib>
#include <string>
#include <utility>

#include "compiler/check/rules/priorities.h"
#include "compiler/check/rules/resolver.h"
#include "runtime/module/abi/actions.h"

namespace meld::check {

namespace {

bool is_of_clock(const Predicate& p) {
    if (!p.prelude || p.kind != PredicateKind::Action) return false;
    for (const ActionInfo& action : known_actions())
        if (action.word == p.name) return action.performer == ActionInfo::Performer::Clock;
    return false;
}

syntax::ExprPtr make_expr(decltype(syntax::Expr::node) node, Span span) {
    return std::make_unique<syntax::Expr>(syntax::Expr{std::move(node), span});
}

}  // namespace

bool is_upwards(const syntax::Hint& hint) {
    return hint.directive.text == "priority" && hint.text.starts_with("@order") && hint.text.ends_with("asc");
}
bool is_downwards(const syntax::Hint& hint) {
    return hint.directive.text == "priority" && hint.text.starts_with("@order") && hint.text.ends_with("desc");
}

std::optional<double> priority_of_all(const syntax::Hint& hint, std::string_view word) {
    if (hint.directive.text != "priority" || !hint.text.starts_with(word)) return std::nullopt;
    const std::string number = hint.text.substr(word.size());
    char* end = nullptr;
    const double value = std::strtod(number.c_str(), &end);
    return end == number.c_str() || *end != '\0' ? std::nullopt : std::optional<double>(value);
}

// With all arguments, or without the first.
std::optional<PredicateId> Resolver::action_of_clock(const syntax::Atom& tree) const {
    const std::size_t arguments = tree.arguments.size();
    for (const std::size_t left_out : {0u, 1u}) {
        const auto found = names_.predicates.find({tree.name.text, arguments + left_out});
        if (found == names_.predicates.end()) continue;
        const Predicate& p = program_.predicates[found->second];
        if (!is_of_clock(p)) return std::nullopt;
        // `remove-priority(A, B)` has them all.
        return found->second;
    }
    return std::nullopt;
}

// The catom that asks is the one at which the rule runs: that of what it consumes; of a view, that of the first fact of its body.
const syntax::Expr& Resolver::asker(const syntax::Atom& tree) const {
    const syntax::Expr* first = nullptr;
    for (const syntax::Clause& clause : tree_->body) {
        const auto* atom = std::get_if<syntax::Atom>(&clause.node);
        if (atom == nullptr || atom->arguments.empty()) continue;
        const auto found = names_.predicates.find({atom->name.text, atom->arguments.size()});
        if (found != names_.predicates.end() && program_.predicates[found->second].linear()) return *atom->arguments[0];
        if (first == nullptr) first = atom->arguments[0].get();
    }
    return first != nullptr ? *first : *tree.arguments[0];
}

void Resolver::ask_clock(const syntax::Atom& tree, PredicateId id, std::vector<Head>& out) {
    const Predicate& p = program_.predicates[id];
    Head h{.kind = Head::Kind::Fact, .span = tree.span};
    h.atom.predicate = id;
    h.atom.span = tree.span;
    const std::size_t left_out = p.arguments.size() - tree.arguments.size();
    if (left_out == 1) h.atom.arguments.push_back(head_location(asker(tree)));
    for (std::size_t i = 0; i < tree.arguments.size(); ++i) {
        const std::size_t at = i + left_out;
        if (at == 0) {
            h.atom.arguments.push_back(head_location(*tree.arguments[i]));
            continue;
        }
        Term value =
            scope_->resolve(*tree.arguments[i], p.arguments[at].type, fmt::format("argument {} of `{}`", i + 1, p.name), false, p.span);
        if (p.arguments[at].type == Type::Float && program_.priorities_upwards) {
            Term less;
            less.op = Op::Negate;
            less.type = Type::Float;
            less.span = value.span;
            less.operands.push_back(std::move(value));
            value = std::move(less);
        }
        h.atom.arguments.push_back(std::move(value));
    }
    out.push_back(std::move(h));
}

// priority @default P. and priority @initial P. are facts of all catoms.
void Resolver::priorities_of_all(const syntax::Hint& hint) {
    for (const auto& [directive, action] : {std::pair("@default", "set-default-priority"), std::pair("@initial", "update-priority")}) {
        const std::optional<double> value = priority_of_all(hint, directive);
        if (!value) continue;
        syntax::Rule fact;
        fact.arrow = syntax::Arrow::Axiom;
        fact.span = hint.span;
        syntax::Atom atom;
        atom.name = {action, hint.directive.span};
        atom.span = hint.span;
        atom.arguments.push_back(make_expr(syntax::Variable{"A"}, hint.span));
        atom.arguments.push_back(make_expr(syntax::FloatLiteral{*value}, hint.span));
        fact.head.push_back({syntax::HeadFact{std::move(atom), std::nullopt}, hint.span});
        rule(fact);
    }
}

}  // namespace meld::check
