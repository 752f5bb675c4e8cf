// Pass 2, types of variables: from the facts of a rule, then from its equalities and aggregates to a fixpoint.
#include "compiler/check/program/library_fold.h"
#include "compiler/check/rules/resolver.h"

namespace meld::check {

void Resolver::type_variables(const std::vector<syntax::Clause>& clauses) {
    type_from_atoms(clauses);
    for (bool changed = true; changed;) {
        changed = false;
        type_from_equalities(clauses, changed);
    }
}

void Resolver::type_heads(const std::vector<syntax::HeadItem>& heads) {
    for (const syntax::HeadItem& item : heads) {
        if (const auto* all = std::get_if<syntax::Comprehension>(&item.node)) {
            const Inside inside(*scope_, *locals_, all);
            type_variables(all->body);
            type_heads(all->head);
        }
        if (const auto* aggregate = std::get_if<syntax::RuleAggregate>(&item.node)) type_rule_aggregate(*aggregate);
        if (const auto* let = std::get_if<syntax::HeadLet>(&item.node)) {
            bool changed = false;
            type_name(let->variable, scope_->infer(*let->value), changed);
        }
        if (const auto* exists = std::get_if<syntax::Exists>(&item.node)) {
            const Inside inside(*scope_, *locals_, exists);
            type_fresh(exists->head);
            type_heads(exists->head);
        }
        if (const auto* choice = std::get_if<syntax::HeadIf>(&item.node)) {
            type_heads(choice->then_head);
            type_heads(choice->else_head);
        }
    }
}

void Resolver::type_rule_aggregate(const syntax::RuleAggregate& aggregate) {
    std::vector<Type> values;
    {
        const Inside inside(*scope_, *locals_, &aggregate);
        type_variables(aggregate.body);
        type_heads(aggregate.each);
        for (const syntax::HeadAggregate& one : aggregate.aggregates)
            values.push_back(one.op == "count" ? Type::Int : rule_->variables[scope_->variable(one.result.text, one.result.span)].type);
    }
    const Inside inside(*scope_, *locals_, &aggregate.result);
    bool changed = false;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const syntax::HeadAggregate& one = aggregate.aggregates[i];
        type_name(one.result, type_of_aggregate(one.op == "custom" ? one.function : one.op, values[i]), changed);
    }
    type_heads(aggregate.result);
}

// The variables of `exists` have the type of the first place where they stand.
void Resolver::type_fresh(const std::vector<syntax::HeadItem>& heads) {
    for (const syntax::HeadItem& item : heads) {
        if (const auto* fact = std::get_if<syntax::HeadFact>(&item.node)) type_from_atom(fact->atom);
        if (const auto* all = std::get_if<syntax::Comprehension>(&item.node)) type_fresh(all->head);
        if (const auto* aggregate = std::get_if<syntax::RuleAggregate>(&item.node)) {
            type_fresh(aggregate->each);
            type_fresh(aggregate->result);
        }
        if (const auto* exists = std::get_if<syntax::Exists>(&item.node)) type_fresh(exists->head);
        if (const auto* choice = std::get_if<syntax::HeadIf>(&item.node)) {
            type_fresh(choice->then_head);
            type_fresh(choice->else_head);
        }
    }
}

void Resolver::type_from_atoms(const std::vector<syntax::Clause>& clauses) {
    for (const syntax::Clause& clause : clauses) {
        if (const auto* atom = std::get_if<syntax::Atom>(&clause.node)) type_from_atom(*atom);
        if (const auto* delta = std::get_if<syntax::Delta>(&clause.node)) type_from_atom(delta->atom);
        if (const auto* negated = std::get_if<syntax::Not>(&clause.node)) {
            const Inside inside(*scope_, *locals_, negated);
            type_from_atoms(negated->clauses);
        }
        if (const auto* all = std::get_if<syntax::Forall>(&clause.node)) {
            const Inside inside(*scope_, *locals_, all);
            type_from_atom(all->atom);
            type_from_atoms(all->clauses);
        }
        if (const auto* aggregate = std::get_if<syntax::BodyAggregate>(&clause.node)) {
            const Inside inside(*scope_, *locals_, aggregate);
            type_from_atoms(aggregate->clauses);
        }
    }
}

void Resolver::type_from_atom(const syntax::Atom& atom) {
    const auto found = names_.predicates.find({atom.name.text, atom.arguments.size()});
    if (found == names_.predicates.end()) return;
    const Predicate& p = program_.predicates[found->second];
    for (std::size_t i = 0; i < atom.arguments.size(); ++i) scope_->spread_type(*atom.arguments[i], p.arguments[i].type);
}

void Resolver::type_from_equalities(const std::vector<syntax::Clause>& clauses, bool& changed) {
    for (const syntax::Clause& clause : clauses) {
        if (const auto* negated = std::get_if<syntax::Not>(&clause.node)) {
            const Inside inside(*scope_, *locals_, negated);
            type_from_equalities(negated->clauses, changed);
        }
        if (const auto* all = std::get_if<syntax::Forall>(&clause.node)) {
            const Inside inside(*scope_, *locals_, all);
            type_from_equalities(all->clauses, changed);
        }
        if (const auto* aggregate = std::get_if<syntax::BodyAggregate>(&clause.node)) {
            Type value = Type::Error;
            {
                const Inside inside(*scope_, *locals_, aggregate);
                type_from_equalities(aggregate->clauses, changed);
                if (aggregate->value != nullptr) value = scope_->infer(*aggregate->value);
            }
            if (aggregate->result.text != "_") type_name(aggregate->result, type_of_aggregate(aggregate->op, value), changed);
        }
        if (const auto* proved = std::get_if<syntax::Proved>(&clause.node))
            if (const std::string* name = scope_->variable_name(*proved->count))
                type_name({*name, proved->count->span}, Type::Int, changed);
        if (const auto* element = std::get_if<syntax::Element>(&clause.node)) {
            const Type list = scope_->infer(*element->list);
            if (list.parts.size() == 1) changed = scope_->spread_type(*element->element, list.parts[0]) || changed;
        }
        const auto* test = std::get_if<syntax::Constraint>(&clause.node);
        const auto* equal = test ? std::get_if<syntax::Binary>(&test->condition->node) : nullptr;
        if (equal == nullptr || equal->op != syntax::BinaryOp::Equal) continue;
        changed = scope_->spread_type(*equal->left, scope_->infer(*equal->right)) || changed;
        changed = scope_->spread_type(*equal->right, scope_->infer(*equal->left)) || changed;
    }
}

void Resolver::type_name(const syntax::Name& variable, const Type& type, bool& changed) {
    Variable& v = rule_->variables[scope_->variable(variable.text, variable.span)];
    if (v.type != Type::Error || type == Type::Error) return;
    v.type = type;
    changed = true;
}

Type Resolver::type_of_aggregate(const std::string& op, const Type& value) const {
    const Aggregate aggregate = aggregate_named(op);
    if (aggregate == Aggregate::Custom) {
        const auto own = names_.functions.find(op);
        return own == names_.functions.end() ? type_of_library_fold(op, value).value_or(value) : program_.functions[own->second].result;
    }
    switch (info(aggregate).result) {
        case AggregateInfo::Result::Same:
            return value;
        case AggregateInfo::Result::Int:
            return Type::Int;
        case AggregateInfo::Result::Float:
            return Type::Float;
        case AggregateInfo::Result::ListOf:
            return value == Type::Error ? Type::Error : Type::list_of(value);
    }
    return value;
}

}  // namespace meld::check
