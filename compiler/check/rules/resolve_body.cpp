// Pass 2, bodies: clauses of the syntax tree to clauses of the checked program.
#include <algorithm>

#include "compiler/check/program/library_fold.h"
#include "compiler/check/program/operators.h"
#include "compiler/check/rules/resolver.h"
#include "compiler/syntax/parse.h"

namespace meld::check {

using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

std::vector<Clause> Resolver::body(const std::vector<syntax::Clause>& clauses) {
    std::vector<Clause> out;
    for (const syntax::Clause& clause : clauses) this->clause(clause, out);
    return out;
}

void Resolver::clause(const syntax::Clause& tree, std::vector<Clause>& out) {
    if (const auto* a = std::get_if<syntax::Atom>(&tree.node)) {
        // A function that gives a bool is a condition.
        if (is_predicate(a->name.text) || !scope_->is_function(a->name.text))
            body_atom(*a, out);
        else
            out.push_back(test(scope_->condition(*a)));
    } else if (const auto* t = std::get_if<syntax::Constraint>(&tree.node)) {
        condition(*t->condition, out);
    } else if (const auto* n = std::get_if<syntax::Not>(&tree.node)) {
        const Inside inside(*scope_, *locals_, n);
        Clause c{.kind = Clause::Kind::Not, .span = tree.span};
        c.inner = body(n->clauses);
        out.push_back(std::move(c));
    } else if (const auto* f = std::get_if<syntax::Forall>(&tree.node)) {
        // A `forall` holds if there is no exception.
        const Inside inside(*scope_, *locals_, f);
        Clause exception{.kind = Clause::Kind::Not, .span = tree.span};
        exception.inner = body(f->clauses);
        Clause c{.kind = Clause::Kind::Not, .span = tree.span};
        body_atom(f->atom, c.inner);
        c.inner.push_back(std::move(exception));
        out.push_back(std::move(c));
    } else if (const auto* b = std::get_if<syntax::BodyAggregate>(&tree.node)) {
        body_aggregate(*b, tree.span, out);
    } else if (const auto* p = std::get_if<syntax::Proved>(&tree.node)) {
        proved(*p, tree.span, out);
    } else if (const auto* d = std::get_if<syntax::Delta>(&tree.node)) {
        delta(*d, tree.span, out);
    } else if (const auto* e = std::get_if<syntax::Element>(&tree.node)) {
        element(*e, tree.span, out);
    }
}

// delta(X; p(A, X)) > e
void Resolver::delta(const syntax::Delta& tree, Span span, std::vector<Clause>& out) {
    std::vector<Clause> fact;
    body_atom(tree.atom, fact);
    Term bound = scope_->resolve(*tree.bound, Type::Error, "the amount of a change");
    if (tree_->arrow == syntax::Arrow::Question) {
        report_.add(Kind::DeltaElsewhere, span, "a question looks at one moment, and `delta` compares two").help =
            "ask in both ticks, or let a rule of the program record the change";
        return;
    }
    if (fact.empty()) return;
    Clause c = std::move(fact[0]);
    c.kind = Clause::Kind::Delta;
    c.span = span;
    c.variable = scope_->variable(tree.variable.text, tree.variable.span);
    c.test = std::move(bound);
    c.compare = op_of(tree.op);
    const auto stands = std::count_if(c.atom.arguments.begin() + 1, c.atom.arguments.end(),
                                      [&](const Term& t) { return t.is_variable() && t.variable == c.variable; });
    const Type& type = rule_->variables[c.variable].type;
    if (stands != 1)
        report_
            .add(Kind::UnboundVariable, tree.variable.span,
                 fmt::format("`{}` must be one argument of `{}`, whose change is tested", tree.variable.text, tree.atom.name.text))
            .help = fmt::format("write delta(X; {}(A, ..., X, ...))", tree.atom.name.text);
    else if (!type.numeric() && type != Type::Error)
        report_.add(Kind::TypeMismatch, tree.variable.span,
                    fmt::format("`{}` is {}, and only numbers change by an amount", tree.variable.text, check::type_name(type)));
    if (!c.test.type.numeric() && c.test.type != Type::Error)
        report_.add(Kind::TypeMismatch, c.test.span, fmt::format("a change is a number, and this is {}", check::type_name(c.test.type)));
    out.push_back(std::move(c));
    for (std::size_t i = 1; i < fact.size(); ++i) out.push_back(std::move(fact[i]));
}

// E in List. If the element is not a variable, a variable is introduced and compared or taken apart.
void Resolver::element(const syntax::Element& tree, Span span, std::vector<Clause>& out) {
    Clause c{.kind = Clause::Kind::Element, .span = span};
    c.test = scope_->resolve(*tree.list, Type::Error, "`in`");
    const Type list = c.test.type;
    if (list != Type::Error && list.kind != Type::Kind::List && list.kind != Type::Kind::Set && list.kind != Type::Kind::Array) {
        report_.add(Kind::TypeMismatch, c.test.span,
                    fmt::format("`in` looks into a list, set or array, and this is {}", check::type_name(list)));
        return;
    }
    // A list without a type has no value either; that is reported where it is used.
    const Type wanted = list.parts.empty() ? Type::Error : list.parts[0];
    std::vector<Clause> tests;
    const Term element = scope_->is_pattern(*tree.element) ? scope_->pattern_variable(*tree.element, wanted, tests)
                                                           : scope_->resolve(*tree.element, wanted, "an element", true);
    if (element.is_variable()) {
        c.variable = element.variable;
        out.push_back(std::move(c));
    } else {
        c.variable = scope_->fresh("_element", wanted, tree.element->span);
        const Term variable = variable_term(c.variable, tree.element->span);
        out.push_back(std::move(c));
        if (element.op != Op::Anonymous) out.push_back(equality(variable, element, tree.element->span));
    }
    for (Clause& t : tests) out.push_back(std::move(t));
}

bool Resolver::is_predicate(const std::string& name) const {
    const auto found = names_.predicates.lower_bound({name, 0});
    return found != names_.predicates.end() && found->first.first == name;
}

std::vector<PredicateId> Resolver::predicates_named(const std::string& name) const {
    std::vector<PredicateId> of_world, of_program;
    for (auto at = names_.predicates.lower_bound({name, 0}); at != names_.predicates.end() && at->first.first == name; ++at)
        (program_.predicates[at->second].prelude ? of_world : of_program).push_back(at->second);
    return of_program.empty() ? of_world : of_program;
}

void Resolver::condition(const syntax::Expr& e, std::vector<Clause>& out) {
    const auto* equal = std::get_if<syntax::Binary>(&e.node);
    const bool patterns =
        equal != nullptr && equal->op == syntax::BinaryOp::Equal && (scope_->is_pattern(*equal->left) || scope_->is_pattern(*equal->right));
    const std::optional<Type> common = patterns ? join(scope_->infer(*equal->left), scope_->infer(*equal->right)) : std::nullopt;
    // Types that do not fit each other are reported where they are compared.
    if (!common) {
        out.push_back(test(scope_->resolve(e, Type::Bool, "a condition")));
        return;
    }
    const bool left = scope_->is_pattern(*equal->left);
    const syntax::Expr &pattern = left ? *equal->left : *equal->right, &other = left ? *equal->right : *equal->left;
    std::vector<Clause> tests;
    Term value = scope_->is_pattern(other) ? scope_->pattern_variable(other, *common, tests) : scope_->resolve(other, *common, "`=`");
    if (!value.is_variable()) {
        Term variable{
            .op = Op::Variable, .type = value.type, .span = other.span, .variable = scope_->fresh("_value", value.type, other.span)};
        tests.push_back(equality(variable, std::move(value), e.span));
        value = variable;
    }
    const std::size_t at = tests.size();
    Term made = scope_->pattern(pattern, *common, tests);
    tests.insert(tests.begin() + static_cast<std::ptrdiff_t>(at), equality(std::move(value), std::move(made), e.span));
    for (Clause& t : tests) out.push_back(std::move(t));
}

void Resolver::body_aggregate(const syntax::BodyAggregate& tree, Span span, std::vector<Clause>& out) {
    Clause c{.kind = Clause::Kind::Aggregate, .span = span};
    c.variable =
        tree.result.text == "_" ? scope_->fresh("_", Type::Error, tree.result.span) : scope_->variable(tree.result.text, tree.result.span);
    {
        const Inside inside(*scope_, *locals_, &tree);
        c.inner = body(tree.clauses);
        if (tree.value != nullptr && tree.op != "count") c.test = scope_->resolve(*tree.value, Type::Error, fmt::format("`{}`", tree.op));
        // Which value is counted makes no difference.
        const Term counted =
            tree.value != nullptr && tree.op == "count" ? scope_->resolve(*tree.value, Type::Error, "`count`", true) : Term{};
        warn_of_one_value(tree, tree.op == "count" ? counted : c.test, c.inner);
    }
    c.aggregate = aggregate(tree.op, c.test, span);
    if (c.aggregate != Aggregate::Custom || tree.parameter != nullptr)
        c.parameter = aggregate_parameter(c.aggregate, tree.parameter, tree.op, span);
    if (c.aggregate == Aggregate::Custom) {
        const std::optional<FunctionId> function = fold_function(tree.op, c.test, FoldStart::FirstValue, span);
        if (!function) return;
        c.fold = *function;
    }
    const Type type = type_of_aggregate(tree.op, c.test.type);
    Variable& result = rule_->variables[c.variable];
    if (result.type == Type::Error) result.type = type;
    if (result.type == type || type == Type::Error) return out.push_back(std::move(c));
    // The result is compared with a value of another type, an int with a float say.
    const VariableId compared = std::exchange(c.variable, scope_->fresh("_", type, tree.result.span));
    Term value = scope_->convert(variable_term(c.variable, tree.result.span), rule_->variables[compared].type,
                                 fmt::format("`{}`", tree.result.text));
    out.push_back(std::move(c));
    out.push_back(equality(variable_term(compared, tree.result.span), std::move(value), tree.result.span));
}

Aggregate Resolver::aggregate_named(const std::string& op) const {
    const Aggregate known = syntax::aggregate_of_matches(op);
    return info(known).has(AggregateInfo::kYields) && names_.functions.contains(op) ? Aggregate::Custom : known;
}

Aggregate Resolver::aggregate(const std::string& op, const Term& value, Span span) {
    const Aggregate aggregate = aggregate_named(op);
    const Type& type = value.type;
    if (aggregate == Aggregate::Custom || type == Type::Error) return aggregate;
    const std::string name = check::type_name(type);
    const auto misuse = [&](const std::string& what, const std::string& help) { report_.add(Kind::BadAggregate, span, what).help = help; };
    switch (info(aggregate).values) {
        case AggregateInfo::Values::Summable:
            if (!summable(type)) misuse(fmt::format("a sum of {} values has no meaning", name), kSummable);
            break;
        case AggregateInfo::Values::Reals:
            if (!type.numeric()) misuse(fmt::format("{} values have no average", name), "average an int or a float");
            break;
        case AggregateInfo::Values::Bools:
            if (type != Type::Bool)
                misuse(fmt::format("`{}` joins truth values, and this is {}", op, name), "write a condition, or a variable that is a bool");
            break;
        default:
            break;
    }
    return aggregate;
}

Term Resolver::aggregate_parameter(Aggregate aggregate, const syntax::ExprPtr& number, const std::string& op, Span span) {
    const bool takes = info(aggregate).has(AggregateInfo::kParameter);
    if (takes != (number != nullptr))
        report_
            .add(Kind::BadAggregate, span,
                 takes ? fmt::format("`{}` needs to know how many values it keeps", op) : fmt::format("`{}` takes no number", op))
            .help = takes ? fmt::format("write `{}(3)`", op) : fmt::format("write `{}` alone", op);
    if (number == nullptr) return {};
    Term limit = scope_->resolve(*number, Type::Int, fmt::format("the number of values that `{}` keeps", op));
    if (limit.op == Op::Int && limit.integer < 1) {
        auto& d = report_.add(Kind::BadAggregate, number->span, fmt::format("`{}` keeps at least one value", op));
        d.help = fmt::format("write `{}(1)`", op);
        d.fixes = {diagnostics::write(number->span, "1")};
    }
    return takes ? limit : Term{};
}

// What is folded has no type: of a variable that nothing gives a value, if no error before says why.
void Resolver::report_without_value(const Term& folded) {
    if (refused_ || report_.error_count() > errors_before_) return;
    each_variable(folded, [&](VariableId v) {
        const Variable& variable = rule_->variables[v];
        if (variable.type != Type::Error || report_.error_count() > errors_before_) return;
        report_.add(Kind::UnboundVariable, folded.span, fmt::format("`{}` has no value for a match", variable.name)).help =
            fmt::format("use `{}` in a fact of the body of the aggregate, or set it there with `{} = ...`", variable.name, variable.name);
    });
}

// The function that folds the values of matches: f(so far, value), with the type of the result so far.
std::optional<FunctionId> Resolver::fold_function(const std::string& name, const Term& value, FoldStart start, Span span) {
    const auto own = names_.functions.find(name);
    if (own == names_.functions.end()) {
        if (names_.tree.is_lost(name)) return std::nullopt;
        if (const std::optional<FunctionId> fold = library_fold(program_, name, value.type, span)) return fold;
        if (const LibraryFunction* f = library_function(name, 2)) {
            if (value.type != Type::Error)
                refuse_library_fold(*f, value.type, span, report_);
            else
                report_without_value(value);
            refused_ = true;
            return std::nullopt;
        }
        const std::vector<std::string> aggregates = syntax::words_of_aggregates_of_matches();
        std::vector<std::string> known;
        known.insert(known.end(), aggregates.begin(), aggregates.end());
        for (const auto& [function, id] : names_.functions) known.push_back(function);
        const std::string near = diagnostics::nearest_name(name, known);
        report_.add(Kind::UnknownFunction, span, fmt::format("there is no aggregate and no function `{}`", name)).help =
            near.empty() ? fmt::format("aggregates are {}, or a function of two arguments", diagnostics::in_words(aggregates))
                         : fmt::format("did you mean `{}`?", near);
        return std::nullopt;
    }
    const Function& f = program_.functions[own->second];
    refused_ = refused_ || f.refused;
    const auto complain = [&](Kind kind, const std::string& what) {
        auto& d = report_.add(kind, span, what);
        d.labels = {{f.span, "declared here"}};
        d.help = fmt::format("write `fun {}(T SoFar, T Value) : T = ...`", name);
        return std::nullopt;
    };
    if (f.parameter_count != 2)
        return complain(Kind::ArityMismatch, fmt::format("a fold takes two arguments, the result so far and a value, and `{}` takes {}",
                                                         name, f.parameter_count));
    const auto fits = [](const Type& from, const Type& to) {
        return from == to || from == Type::Error || to == Type::Error || (from == Type::Int && to == Type::Float);
    };
    const Type &so_far = f.variables[VariableId(0)].type, &each = f.variables[VariableId(1)].type;
    if (!(so_far == f.result))
        return complain(Kind::TypeMismatch, fmt::format("`{}` gets its previous result, {}, and takes {}", name, check::type_name(f.result),
                                                        check::type_name(so_far)));
    if (!fits(value.type, each))
        return complain(Kind::TypeMismatch,
                        fmt::format("`{}` folds {} values, and these are {}", name, check::type_name(each), check::type_name(value.type)));
    if (start == FoldStart::FirstValue && !(each == f.result))
        return complain(Kind::TypeMismatch, fmt::format("`{}` starts from the first value, {}, and gives {}", name, check::type_name(each),
                                                        check::type_name(f.result)));
    return own->second;
}

// The number of facts at the execution site, which place_counts() inserts when the site is known.
void Resolver::proved(const syntax::Proved& tree, Span span, std::vector<Clause>& out) {
    const std::vector<PredicateId> named = predicates_named(tree.predicate.text);
    if (names_.tree.is_lost(tree.predicate.text)) {
        refused_ = true;
        return;
    }
    if (named.empty()) {
        unknown_predicate(tree.predicate, std::nullopt, Part::Body);
        return;
    }
    if (named.size() > 1) {
        auto& d = report_.add(
            Kind::ArityMismatch, tree.predicate.span,
            fmt::format("there are {} predicates `{}`, with different numbers of arguments", named.size(), tree.predicate.text));
        // Copied, since g++ 12 warns of the move of a short constant.
        const std::string here = "one is declared here";
        for (const PredicateId id : named) d.labels.push_back({program_.predicates[id].span, here});
        d.help = fmt::format("say which: `N = count : {{ {}(A, _) }}`", tree.predicate.text);
        return;
    }
    const Predicate& p = program_.predicates[named[0]];
    refused_ = refused_ || p.refused;
    if (p.kind == PredicateKind::Action)
        report_.add(Kind::ActionInBody, tree.predicate.span, fmt::format("`{}` is an action, a request; it cannot be read", p.name)).help =
            "read the facts that lead to it";
    Clause c{.kind = Clause::Kind::Aggregate, .aggregate = Aggregate::Count, .span = span};
    Clause fact{.kind = Clause::Kind::Atom, .span = span};
    fact.atom.predicate = named[0];
    fact.atom.span = tree.predicate.span;
    for (const Argument& argument : p.arguments) {
        Term any;
        any.type = argument.type;
        any.span = tree.predicate.span;
        fact.atom.arguments.push_back(std::move(any));
    }
    // A declaration without a catom has been refused.
    if (p.arguments.empty()) return;
    if (tree.at != nullptr) fact.atom.arguments[0] = location(*tree.at, &out);
    c.inner.push_back(std::move(fact));
    Term count = scope_->resolve(*tree.count, Type::Int, "a number of facts", true);
    if (count.is_variable()) {
        c.variable = count.variable;
        return out.push_back(std::move(c));
    }
    c.variable = scope_->fresh("_", Type::Int, tree.count->span);
    out.push_back(std::move(c));
    if (count.op != Op::Anonymous)
        out.push_back(equality(variable_term(out.back().variable, tree.count->span), std::move(count), tree.count->span));
}

Term Resolver::variable_term(VariableId id, Span span) const {
    Term term;
    term.op = Op::Variable;
    term.type = rule_->variables[id].type;
    term.variable = id;
    term.span = span;
    return term;
}

Clause Resolver::test(Term term) {
    Clause c{.kind = Clause::Kind::Test};
    c.span = term.span;
    c.test = std::move(term);
    return c;
}

static std::vector<VariableId> variables_of(const Term& term) {
    std::vector<VariableId> all;
    each_variable(term, [&](VariableId v) { all.push_back(v); });
    return all;
}

Term Resolver::location(const syntax::Expr& e, std::vector<Clause>* tests) {
    if (scope_->variable_name(e) != nullptr) return scope_->resolve(e, Type::Node, "the place of a fact");
    Term term;
    term.op = Op::Variable;
    term.type = Type::Node;
    term.span = e.span;
    if (std::holds_alternative<syntax::Anonymous>(e.node)) {
        term.variable = scope_->fresh("_", Type::Node, e.span);
        return term;
    }
    // Several uses of one computed catom in a rule are one place, unless a part of the rule means other variables by its names.
    const bool lasting = !scope_->inside_part();
    const std::string key = syntax::print(e);
    const auto known = places_.find(key);
    if (lasting && known != places_.end()) {
        term.variable = known->second.variable;
        return term;
    }
    Term value = scope_->resolve(e, Type::Node, "the place of a fact");
    if (known != places_.end() && variables_of(value) == variables_of(known->second.value)) {
        term.variable = known->second.variable;
        return term;
    }
    if (is_fixed(value)) {
        term.variable = variable_of_fixed(std::move(value), lasting && tests != nullptr ? *tests : fixed_inside_);
        return term;
    }
    term.variable = scope_->fresh("_at", Type::Node, e.span);
    if (lasting) places_[key] = {value, term.variable};
    if (tests != nullptr) tests->push_back(equality(term, std::move(value), e.span));
    return term;
}

void Resolver::body_atom(const syntax::Atom& tree, std::vector<Clause>& out) {
    const std::optional<PredicateId> id = find(tree, Part::Body);
    if (!id) return visit_anyway(tree);
    const Predicate& p = program_.predicates[*id];
    sigil(tree, p);
    not_a_negation(tree, p);
    if (p.kind == PredicateKind::Action && tree_->arrow != syntax::Arrow::Question)
        report_.add(Kind::ActionInBody, tree.span, fmt::format("`{}` is an action, a request; it cannot be read", p.name)).help =
            "read the facts that lead to it";
    Clause c{.kind = Clause::Kind::Atom, .span = tree.span};
    c.atom.predicate = *id;
    c.atom.span = tree.span;
    c.atom.read_only = tree.sigil == syntax::Sigil::Read;
    std::vector<Clause> tests;
    for (std::size_t i = 0; i < tree.arguments.size(); ++i) {
        const std::string where = fmt::format("argument {} of `{}`", i + 1, p.name);
        if (i == 0)
            c.atom.arguments.push_back(location(*tree.arguments[i], &tests));
        else if (scope_->is_pattern(*tree.arguments[i]))
            c.atom.arguments.push_back(scope_->pattern_variable(*tree.arguments[i], p.arguments[i].type, tests));
        else
            c.atom.arguments.push_back(scope_->resolve(*tree.arguments[i], p.arguments[i].type, where, true, p.span));
    }
    out.push_back(std::move(c));
    for (Clause& t : tests) out.push_back(std::move(t));
}

void Resolver::visit_anyway(const syntax::Atom& tree) {
    for (const auto& argument : tree.arguments)
        if (const std::string* name = scope_->variable_name(*argument)) scope_->variable(*name, argument->span);
}

}  // namespace meld::check
