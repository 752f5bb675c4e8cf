// Pass 2, catoms that a rule names: q(A) :- neighbor(A, @1), p(@1). is q(A) :- neighbor(A, V), p(V), V = @1.
// Later passes join catoms by variables, so a literal or constant that says where a fact is, or where a link leads, becomes one variable
// of the whole rule, also where a negation, an aggregate or a head names it. Messages still show what the program says: the variable has
// the span of the text, and Sites prints its value.
#include <algorithm>
#include <functional>

#include "compiler/check/rules/resolver.h"

namespace meld::check {

namespace {

const Constant* constant_of(const Program& program, const Term& t) {
    return t.op == Op::Constant ? &program.constants[t.constant] : nullptr;
}

// Whether both are known to be the same catom: the same number, or the same constant.
bool same_catom(const Program& program, const Term& a, const Term& b) {
    const Constant *left = constant_of(program, a), *right = constant_of(program, b);
    if (left != nullptr && left == right) return true;
    const auto known = [](const Constant* c) { return c == nullptr || (!c->argument && !c->computed.valid()); };
    if (!known(left) || !known(right)) return false;
    return (left != nullptr ? left->integer : a.integer) == (right != nullptr ? right->integer : b.integer);
}

// Calls visit(atom) for every atom of these bodies, those inside negations and aggregates too.
template <class Visit>
void each_atom_in(std::vector<Clause>& body, const Visit& visit) {
    for (Clause& c : body) {
        if (c.kind == Clause::Kind::Atom || c.kind == Clause::Kind::Delta) visit(c.atom);
        each_atom_in(c.inner, visit);
    }
}
template <class Visit>
void each_atom_in(std::vector<Head>& heads, const Visit& read, const Visit& made) {
    for (Head& h : heads) {
        if (h.kind == Head::Kind::Fact) made(h.atom);
        each_atom_in(h.body, read);
        each_atom_in(h.heads, read, made);
        each_atom_in(h.others, read, made);
    }
}

}  // namespace

bool Resolver::is_fixed(const Term& value) { return value.type == Type::Node && (value.op == Op::Node || value.op == Op::Constant); }

const Resolver::Place* Resolver::fixed_place(const Term& value) const {
    if (!is_fixed(value)) return nullptr;
    const auto found = std::ranges::find_if(fixed_, [&](const Place& f) { return same_catom(program_, f.value, value); });
    return found == fixed_.end() ? nullptr : &*found;
}

VariableId Resolver::variable_of_fixed(Term value, std::vector<Clause>& tests) {
    if (const Place* known = fixed_place(value)) return known->variable;
    const Span span = value.span;
    const VariableId made = scope_->fresh("_at", Type::Node, span);
    fixed_.push_back({value, made});
    tests.push_back(equality(variable_term(made, span), std::move(value), span));
    return made;
}

// A link to a catom that no fact of the rule is at may still be half of a way: neighbor(A, @1), neighbor(B, @1).
void Resolver::name_far_ends(Rule& rule) {
    std::vector<std::pair<Term, int>> ends;
    const auto count = [&](Atom& a) {
        if (!program_.predicates[a.predicate].route || a.arguments.size() < 2 || !is_fixed(a.arguments[1])) return;
        const auto same = [&](const auto& end) { return same_catom(program_, end.first, a.arguments[1]); };
        const auto known = std::ranges::find_if(ends, same);
        if (known == ends.end())
            ends.emplace_back(a.arguments[1], 1);
        else
            ++known->second;
    };
    const auto nothing = [](Atom&) {};
    each_atom_in(rule.body, count);
    each_atom_in<std::function<void(Atom&)>>(rule.heads, count, nothing);
    for (auto& [value, uses] : ends)
        if (uses > 1) variable_of_fixed(std::move(value), rule.body);
}

// Where the body says V = @1 itself, the catom is V.
void Resolver::use_given_names(Rule& rule) {
    std::map<VariableId, VariableId> given;
    for (const Clause& c : rule.body) {
        if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) continue;
        for (const std::size_t side : {0u, 1u}) {
            const Term& name = c.test.operands[side];
            const Place* catom = name.is_variable() ? fixed_place(c.test.operands[1 - side]) : nullptr;
            if (catom != nullptr && name.variable != catom->variable) given.try_emplace(catom->variable, name.variable);
        }
    }
    if (given.empty()) return;
    std::erase_if(rule.body, [&](const Clause& c) {
        return c.kind == Clause::Kind::Test && c.test.op == Op::Equal && c.test.operands[0].is_variable() &&
               given.contains(c.test.operands[0].variable);
    });
    const auto rename = [&](VariableId& v) {
        if (const auto found = given.find(v); found != given.end()) v = found->second;
    };
    for (Clause& c : rule.body) rewrite_variables(c, rename);
    for (Head& h : rule.heads) rewrite_variables(h, rename);
    for (Place& f : fixed_) rename(f.variable);
}

void Resolver::unify_fixed_catoms(Rule& rule) {
    std::ranges::move(fixed_inside_, std::back_inserter(rule.body));
    fixed_inside_.clear();
    name_far_ends(rule);
    if (fixed_.empty()) return;
    use_given_names(rule);
    const std::function<void(Atom&)> name = [&](Atom& a) {
        for (Term& argument : a.arguments)
            if (const Place* catom = fixed_place(argument)) argument = variable_term(catom->variable, argument.span);
    };
    each_atom_in(rule.body, name);
    // Facts of the text, edge(@0, @1), stay facts of literals.
    const bool reads = std::ranges::any_of(rule.body, [](const Clause& c) { return c.kind != Clause::Kind::Test; });
    const std::function<void(Atom&)> nothing = [](Atom&) {};
    each_atom_in(rule.heads, name, reads ? name : nothing);
}

}  // namespace meld::check
