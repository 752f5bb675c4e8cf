// Walks over a syntax tree: every name that an item declares or uses, with the kind of thing it names.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "compiler/check/program/program.h"
#include "compiler/syntax/tree.h"

namespace meld::check {

// The atom inside `stable(p(A, X), 5)`; none for other atoms.
inline syntax::Call* stable_fact(syntax::Atom& a) {
    if (a.name.text != "stable" || a.arguments.size() != 2) return nullptr;
    auto* fact = std::get_if<syntax::Call>(&a.arguments[0]->node);
    return fact != nullptr && fact->parentheses ? fact : nullptr;
}

// Visit has five functions, each of which may change the name it is given:
//   predicate(syntax::Name&, std::optional<std::size_t> arity)    an atom, or a predicate named alone (no arity)
//   constant(std::string& name, Span)                              a bare small-letter name in an expression
//   capital(syntax::Expr&)                                         a bare capital name, a variable unless it is a constant
//   function(std::string& name, Span)                              f in f(X), and functions of custom aggregates
//   type(syntax::Type&)                                            every type and part of a type, innermost first
// It may have a sixth, expression(syntax::Expr&), for every expression after its parts, which may put another in its place.
template <class Visit>
class EachName {
  public:
    explicit EachName(Visit& visit) : visit_(visit) {}

    void type(syntax::Type& t) {
        for (syntax::Type& part : t.arguments) type(part);
        visit_.type(t);
    }

    void expr(syntax::ExprPtr& e) {
        if (e) expr(*e);
    }
    void expr(syntax::Expr& e) {
        using namespace syntax;
        if (auto* call = std::get_if<Call>(&e.node)) {
            exprs(call->arguments);
            call->parentheses ? visit_.function(call->name, e.span) : visit_.constant(call->name, e.span);
        } else if (auto* unary = std::get_if<Unary>(&e.node)) {
            expr(unary->operand);
        } else if (auto* binary = std::get_if<Binary>(&e.node)) {
            expr(binary->left);
            expr(binary->right);
        } else if (auto* chain = std::get_if<Chain>(&e.node)) {
            for (ExprPtr& operand : chain->operands) expr(operand);
        } else if (auto* conditional = std::get_if<Conditional>(&e.node)) {
            expr(conditional->condition);
            expr(conditional->then_value);
            expr(conditional->else_value);
        } else if (auto* let = std::get_if<Let>(&e.node)) {
            expr(let->value);
            expr(let->body);
        } else if (auto* list = std::get_if<ListValue>(&e.node)) {
            exprs(list->elements);
            expr(list->rest);
        } else if (auto* record = std::get_if<StructValue>(&e.node)) {
            exprs(record->fields);
        } else if (auto* tuple = std::get_if<TupleValue>(&e.node)) {
            exprs(tuple->fields);
        } else if (std::holds_alternative<syntax::Variable>(e.node)) {
            visit_.capital(e);
        }
        if constexpr (requires { visit_.expression(e); }) visit_.expression(e);
    }

    void item(syntax::Declaration& d) {
        for (syntax::Argument& a : d.arguments) {
            type(a.type);
            if (may_be_function(a.aggregate, syntax::declared_aggregate(a.aggregate))) visit_.function(a.aggregate, a.aggregate_span);
            if (a.aggregate_parameter)
                if (auto* constant = std::get_if<syntax::Name>(&*a.aggregate_parameter)) visit_.constant(constant->text, constant->span);
            if (a.neighbour_complete && !a.neighbour_link.text.empty()) visit_.predicate(a.neighbour_link, std::nullopt);
        }
    }
    void item(syntax::Constant& c) { expr(c.value); }
    void item(syntax::Function& f) {
        for (syntax::Parameter& p : f.parameters) type(p.type);
        type(f.result);
        expr(f.body);
    }
    void item(syntax::Extern& e) {
        if (e.result) type(*e.result);
        for (syntax::Type& t : e.arguments) type(t);
    }
    void item(syntax::Alias& a) { type(a.type); }
    void item(syntax::Import& i) {
        if (i.declaration) item(*i.declaration);
    }
    void item(syntax::Rule& r) {
        clauses(r.body);
        heads(r.head);
    }
    void item(syntax::NodeKind&) {}
    void item(syntax::Export&) {}
    void item(syntax::Module&) {}
    void item(syntax::Hint&) {}
    void item(syntax::Item& any) {
        std::visit([&](auto& one) { item(one); }, any);
    }

  private:
    // Whether the word may name a function of the program: if it is not an aggregate, or one over which such a function takes precedence.
    static bool may_be_function(const std::string& word, Aggregate known) {
        return !word.empty() && (known == Aggregate::Custom || info(known).has(AggregateInfo::kYields));
    }
    void exprs(std::vector<syntax::ExprPtr>& all) {
        for (syntax::ExprPtr& e : all) expr(e);
    }
    void atom(syntax::Atom& a) {
        if (syntax::Call* fact = stable_fact(a)) {
            exprs(fact->arguments);
            syntax::Name name{fact->name, a.arguments[0]->span};
            visit_.predicate(name, fact->arguments.size());
            fact->name = name.text;
            return expr(a.arguments[1]);
        }
        exprs(a.arguments);
        visit_.predicate(a.name, a.arguments.size());
    }

    void clauses(std::vector<syntax::Clause>& all) {
        for (syntax::Clause& c : all) std::visit([&](auto& one) { clause(one); }, c.node);
    }
    void clause(syntax::Atom& a) { atom(a); }
    void clause(syntax::Constraint& c) { expr(c.condition); }
    void clause(syntax::Not& n) { clauses(n.clauses); }
    void clause(syntax::Forall& f) {
        atom(f.atom);
        clauses(f.clauses);
    }
    void clause(syntax::Element& e) {
        expr(e.element);
        expr(e.list);
    }
    void clause(syntax::Delta& d) {
        atom(d.atom);
        expr(d.bound);
    }
    void clause(syntax::Proved& p) {
        expr(p.count);
        expr(p.at);
        visit_.predicate(p.predicate, std::nullopt);
    }
    void clause(syntax::BodyAggregate& a) {
        if (may_be_function(a.op, syntax::aggregate_of_matches(a.op))) visit_.function(a.op, a.result.span);
        expr(a.parameter);
        expr(a.value);
        clauses(a.clauses);
    }

    void heads(std::vector<syntax::HeadItem>& all) {
        for (syntax::HeadItem& h : all) std::visit([&](auto& one) { head(one); }, h.node);
    }
    void head(syntax::HeadFact& f) { atom(f.atom); }
    void head(syntax::Comprehension& c) {
        clauses(c.body);
        heads(c.head);
    }
    void head(syntax::RuleAggregate& a) {
        for (syntax::HeadAggregate& one : a.aggregates) {
            expr(one.parameter);
            if (!one.function.empty()) visit_.function(one.function, one.result.span);
        }
        clauses(a.body);
        heads(a.each);
        heads(a.result);
    }
    void head(syntax::Exists& e) { heads(e.head); }
    void head(syntax::HeadIf& i) {
        expr(i.condition);
        heads(i.then_head);
        heads(i.else_head);
    }
    void head(syntax::HeadLet& l) { expr(l.value); }
    void head(syntax::Nothing&) {}

    Visit& visit_;
};

}  // namespace meld::check
