#include "compiler/check/names/local_names.h"

namespace meld::check {

LocalNames::LocalNames(const syntax::Rule& rule, NameOf name_of) : name_of_(std::move(name_of)) {
    Names known;
    add(rule.body, known);
    add(rule.head, known);
    visit(rule.body, known);
    visit(rule.head, known);
}

void LocalNames::add(const syntax::Expr& e, Names& out) const {
    if (const std::string* name = name_of_(e)) {
        out.insert(*name);
        return;
    }
    const auto all = [&](const std::vector<syntax::ExprPtr>& parts) {
        for (const syntax::ExprPtr& part : parts) add(*part, out);
    };
    if (const auto* call = std::get_if<syntax::Call>(&e.node)) all(call->arguments);
    if (const auto* unary = std::get_if<syntax::Unary>(&e.node)) add(*unary->operand, out);
    if (const auto* binary = std::get_if<syntax::Binary>(&e.node)) {
        add(*binary->left, out);
        add(*binary->right, out);
    }
    if (const auto* chain = std::get_if<syntax::Chain>(&e.node))
        for (const syntax::ExprPtr& operand : chain->operands) add(*operand, out);
    if (const auto* choice = std::get_if<syntax::Conditional>(&e.node)) {
        add(*choice->condition, out);
        add(*choice->then_value, out);
        add(*choice->else_value, out);
    }
    if (const auto* let = std::get_if<syntax::Let>(&e.node)) {
        add(*let->value, out);
        Names inside;
        add(*let->body, inside);
        inside.erase(let->variable.text);
        out.merge(inside);
    }
    if (const auto* list = std::get_if<syntax::ListValue>(&e.node)) {
        all(list->elements);
        if (list->rest != nullptr) add(*list->rest, out);
    }
    if (const auto* fields = std::get_if<syntax::StructValue>(&e.node)) all(fields->fields);
    if (const auto* fields = std::get_if<syntax::TupleValue>(&e.node)) all(fields->fields);
}

void LocalNames::add(const syntax::Atom& atom, Names& out) const {
    for (const syntax::ExprPtr& argument : atom.arguments) add(*argument, out);
}

// The names in the clauses themselves, not those in nested ones.
void LocalNames::add(const Clauses& clauses, Names& out) const {
    for (const syntax::Clause& clause : clauses) {
        if (const auto* atom = std::get_if<syntax::Atom>(&clause.node)) add(*atom, out);
        if (const auto* test = std::get_if<syntax::Constraint>(&clause.node)) add(*test->condition, out);
        if (const auto* proved = std::get_if<syntax::Proved>(&clause.node)) {
            add(*proved->count, out);
            if (proved->at != nullptr) add(*proved->at, out);
        }
        if (const auto* aggregate = std::get_if<syntax::BodyAggregate>(&clause.node)) {
            out.insert(aggregate->result.text);
            if (aggregate->parameter != nullptr) add(*aggregate->parameter, out);
        }
        if (const auto* element = std::get_if<syntax::Element>(&clause.node)) {
            add(*element->element, out);
            add(*element->list, out);
        }
        if (const auto* delta = std::get_if<syntax::Delta>(&clause.node)) {
            add(delta->atom, out);
            add(*delta->bound, out);
        }
    }
}

void LocalNames::add(const Heads& heads, Names& out) const {
    for (const syntax::HeadItem& item : heads) {
        if (const auto* fact = std::get_if<syntax::HeadFact>(&item.node)) add(fact->atom, out);
        if (const auto* let = std::get_if<syntax::HeadLet>(&item.node)) {
            out.insert(let->variable.text);
            add(*let->value, out);
        }
        if (const auto* choice = std::get_if<syntax::HeadIf>(&item.node)) {
            add(*choice->condition, out);
            add(choice->then_head, out);
            add(choice->else_head, out);
        }
    }
}

LocalNames::Names LocalNames::open(const void* part, const Names& direct, const Names& known, const Names& always) {
    Names& locals = locals_[part];
    locals = always;
    for (const std::string& name : direct)
        if (!known.contains(name)) locals.insert(name);
    Names inside = known;
    inside.insert(locals.begin(), locals.end());
    return inside;
}

void LocalNames::visit(const Clauses& clauses, const Names& known) {
    const auto inner = [&](const void* part, const Clauses& body, Names direct) {
        add(body, direct);
        visit(body, open(part, direct, known));
    };
    for (const syntax::Clause& clause : clauses) {
        if (const auto* negation = std::get_if<syntax::Not>(&clause.node)) inner(negation, negation->clauses, {});
        if (const auto* all = std::get_if<syntax::Forall>(&clause.node)) {
            Names direct;
            add(all->atom, direct);
            inner(all, all->clauses, direct);
        }
        if (const auto* aggregate = std::get_if<syntax::BodyAggregate>(&clause.node)) {
            Names direct;
            if (aggregate->value != nullptr) add(*aggregate->value, direct);
            inner(aggregate, aggregate->clauses, direct);
        }
    }
}

void LocalNames::visit(const Heads& heads, const Names& known) {
    for (const syntax::HeadItem& item : heads) {
        if (const auto* all = std::get_if<syntax::Comprehension>(&item.node)) {
            Names direct;
            add(all->body, direct);
            add(all->head, direct);
            const Names inside = open(all, direct, known);
            visit(all->body, inside);
            visit(all->head, inside);
        }
        if (const auto* aggregate = std::get_if<syntax::RuleAggregate>(&item.node)) visit(*aggregate, known);
        if (const auto* exists = std::get_if<syntax::Exists>(&item.node)) {
            Names own;
            for (const syntax::Name& name : exists->variables) own.insert(name.text);
            visit(exists->head, open(exists, {}, known, own));
        }
        if (const auto* choice = std::get_if<syntax::HeadIf>(&item.node)) {
            visit(choice->then_head, known);
            visit(choice->else_head, known);
        }
    }
}

// In the body a result's name means the value of one match; in the last heads the result over all matches.
void LocalNames::visit(const syntax::RuleAggregate& aggregate, const Names& known) {
    Names results, direct;
    for (const syntax::HeadAggregate& one : aggregate.aggregates) results.insert(one.result.text);
    add(aggregate.body, direct);
    add(aggregate.each, direct);
    const Names inside = open(&aggregate, direct, known, results);
    visit(aggregate.body, inside);
    visit(aggregate.each, inside);
    Names last;
    add(aggregate.result, last);
    visit(aggregate.result, open(&aggregate.result, last, known, results));
}

}  // namespace meld::check
