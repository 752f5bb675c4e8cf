// Pass 2, heads: items of the syntax tree to heads of the checked program.
#include <algorithm>

#include "compiler/check/program/library_fold.h"
#include "compiler/check/rules/resolver.h"
#include "runtime/base/assert.h"

namespace meld::check {

using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

std::vector<Head> Resolver::heads(std::span<const syntax::HeadItem> items) {
    std::vector<Head> out;
    for (std::size_t i = 0; i < items.size(); ++i) {
        if (const auto* let = std::get_if<syntax::HeadLet>(&items[i].node)) {
            out.push_back(head_let(*let, items.subspan(i + 1)));
            return out;
        }
        head(items[i], out);
    }
    return out;
}

// The heads after it are inside it.
Head Resolver::head_let(const syntax::HeadLet& tree, std::span<const syntax::HeadItem> behind) {
    Head h{.kind = Head::Kind::Set, .span = tree.variable.span};
    h.variable = scope_->variable(tree.variable.text, tree.variable.span);
    const Type type = rule_->variables[h.variable].type;
    h.term = scope_->resolve(*tree.value, type, fmt::format("`{}`", tree.variable.text));
    if (type == Type::Error) rule_->variables[h.variable].type = h.term.type;
    h.heads = heads(behind);
    return h;
}

void Resolver::head(const syntax::HeadItem& item, std::vector<Head>& out) {
    if (const auto* f = std::get_if<syntax::HeadFact>(&item.node)) {
        head_fact(*f, out);
    } else if (const auto* c = std::get_if<syntax::Comprehension>(&item.node)) {
        const Inside inside(*scope_, *locals_, c);
        Head h{.kind = Head::Kind::Comprehension, .span = item.span};
        h.body = body(c->body);
        warn_of_one_value(c->variables, c, h.body, "comprehension");
        h.heads = heads(c->head);
        out.push_back(std::move(h));
    } else if (const auto* a = std::get_if<syntax::RuleAggregate>(&item.node)) {
        rule_aggregate(*a, item.span, out);
    } else if (const auto* e = std::get_if<syntax::Exists>(&item.node)) {
        exists(*e, item.span, out);
    } else if (const auto* i = std::get_if<syntax::HeadIf>(&item.node)) {
        Head h{.kind = Head::Kind::If, .span = item.span};
        h.term = scope_->resolve(*i->condition, Type::Bool, "`if`");
        h.heads = heads(i->then_head);
        h.others = heads(i->else_head);
        out.push_back(std::move(h));
    }
}

// A predicate of the program's own with the same arguments, which its rules can read instead.
void Resolver::derive_own_instead(const syntax::Atom& tree, const Predicate& p) {
    auto& d = report_.add(Kind::DerivedSensed, tree.span, fmt::format("`{}` is sensed: only the runtime says where it holds", p.name));
    const std::string own = "own-" + p.name;
    const auto taken = names_.predicates.find({own, p.arguments.size()});
    if (taken != names_.predicates.end() && program_.predicates[taken->second].sensed) return;
    std::string declaration = fmt::format("type {}{}{}(", p.linear() ? "linear " : "", p.route ? "route " : "", own);
    for (std::size_t i = 0; i < p.arguments.size(); ++i) declaration += (i == 0 ? "" : ", ") + check::type_name(p.arguments[i].type);
    declaration += ").";
    d.help = fmt::format("derive a predicate of your own, and read that: `{}`", declaration);
    if (taken != names_.predicates.end()) return;
    d.fixes = {{.title = fmt::format("Derive `{}`", own),
                .edits = {later_.declaration(tree_->span, std::move(declaration)), {tree.name.span, own}}}};
}

void Resolver::head_fact(const syntax::HeadFact& item, std::vector<Head>& out) {
    const syntax::Atom& tree = item.atom;
    if (is_scheduling(tree)) return note_scheduling(tree);
    if (const std::optional<PredicateId> of_clock = action_of_clock(tree)) return ask_clock(tree, *of_clock, out);
    if (is_deletion(tree)) return deletion(tree, out);
    const std::optional<PredicateId> id = find(tree, Part::Head);
    if (!id) return visit_anyway(tree);
    const Predicate& p = program_.predicates[*id];
    MELD_ASSERT(p.arguments.size() == tree.arguments.size(), "{} with {} arguments", p.signature(), tree.arguments.size());
    sigil(tree, p);
    if (p.sensed) derive_own_instead(tree, p);
    Head h{.kind = Head::Kind::Fact, .span = tree.span};
    h.atom.predicate = *id;
    h.atom.span = tree.span;
    for (std::size_t i = 0; i < tree.arguments.size(); ++i) {
        const bool counted = p.aggregate == Aggregate::Count && p.aggregate_at == i;
        if (i == 0)
            h.atom.arguments.push_back(head_location(*tree.arguments[i]));
        else if (counted)
            h.atom.arguments.push_back(scope_->resolve(*tree.arguments[i], Type::Error, "a count"));
        else if (info(p.aggregate).values == AggregateInfo::Values::Elements && p.aggregate_at == i)
            h.atom.arguments.push_back(one_element(p, *tree.arguments[i]));
        else
            h.atom.arguments.push_back(
                scope_->resolve(*tree.arguments[i], p.arguments[i].type, fmt::format("argument {} of `{}`", i + 1, p.name), false, p.span));
    }
    if (p.prelude && p.name == "watch" && h.atom.arguments.size() == 2) check_watched(h.atom.arguments[1]);
    if (item.delay) h.delay = delay(*item.delay);
    out.push_back(std::move(h));
}

// The value for an aggregate of elements: a list of that one value.
Term Resolver::one_element(const Predicate& p, const syntax::Expr& e) {
    MELD_EXPECT(p.aggregate_at > 0 && p.aggregate_at < p.arguments.size(), "{} aggregates argument {}", p.name, p.aggregate_at);
    const Type& list = p.arguments[p.aggregate_at].type;
    const Type element = list.parts.empty() ? Type::Error : list.parts[0];
    Term only = scope_->resolve(e, element, fmt::format("one element of argument {} of `{}`", p.aggregate_at + 1, p.name));
    return {.op = Op::List, .type = list, .span = e.span, .operands = {std::move(only)}};
}

// In Linear Meld a rule can say which processor runs a node. Here that has no effect, unless the program means its own predicate.
bool Resolver::is_scheduling(const syntax::Atom& tree) const {
    static const std::set<std::string> words = {"set-static", "set-moving", "set-affinity", "set-cpu", "setprio", "schedule", "set-thread"};
    return words.contains(tree.name.text) && !is_predicate(tree.name.text);
}

// Its arguments have no effect either, so nothing is asked of them. One note for all uses of the word, with a fix for all.
void Resolver::note_scheduling(const syntax::Atom& tree) {
    diagnostics::Diagnostic*& note = hint_notes_[tree.name.text];
    const bool first = note == nullptr;
    if (first) note = &report_.add(Kind::HintIgnored, tree.span, fmt::format("`{}` has no effect here", tree.name.text));
    note->help = first ? "results do not depend on it; it can be left out" : "results do not depend on it; it can be left out everywhere";
    // A rule that only consumes has the head 1; one that only gives a hint goes.
    const bool alone = tree_->body.empty() && tree_->head.size() == 1 && tree_->span.begin == tree.span.begin;
    const diagnostics::Edit edit = alone ? diagnostics::Edit{tree_->span, "", Fit::Item} : diagnostics::Edit{tree.span, "1", Fit::Element};
    if (first) note->fixes = {{.title = "Leave out this hint", .edits = {}, .safe = true}};
    if (!first) note->fixes.front().title = "Leave out these hints";
    note->fixes.front().edits.push_back(edit);
    for (const auto& argument : tree.arguments)
        for (const std::string& name : locals_->names_in(*argument)) hinted_.insert(scope_->variable(name, argument->span));
}

// delete(A, p) and delete(A, p, V), of older Meld: consumes all linear facts of p at A, or those whose argument after A is V.
bool Resolver::is_deletion(const syntax::Atom& tree) const {
    if (tree.name.text != "delete" || tree.arguments.size() < 2 || is_predicate("delete")) return false;
    const auto* named = std::get_if<syntax::Call>(&tree.arguments[1]->node);
    if (named == nullptr || named->parentheses) return false;
    // A name that is misspelt, where no lower-case word is a variable.
    const bool misspelt = dialect_linear_ && !names_.constants.contains(named->name);
    return is_predicate(named->name) || names_.tree.is_lost(named->name) || misspelt;
}

void Resolver::deletion(const syntax::Atom& tree, std::vector<Head>& out) {
    const std::string& name = std::get<syntax::Call>(tree.arguments[1]->node).name;
    const std::size_t values = tree.arguments.size() - 2;
    bool fits = names_.tree.is_lost(name);
    refused_ = refused_ || fits;
    if (!fits && !is_predicate(name)) {
        unknown_predicate({name, tree.arguments[1]->span}, std::nullopt, Part::Body);
        return;
    }
    for (const PredicateId id : predicates_named(name)) {
        const Predicate& p = program_.predicates[id];
        if (p.arguments.size() < 1 + values) continue;
        fits = true;
        refused_ = refused_ || p.refused;
        if (!p.linear()) {
            auto& d =
                report_.add(Kind::OnlyConsuming, tree.span, fmt::format("`{}` is not linear, and only linear facts are consumed", name));
            d.labels = {{p.span, "declared here"}};
            d.help = "a view goes when its body fails; to take facts back, declare their predicate `linear`";
            continue;
        }
        Clause fact{.kind = Clause::Kind::Atom, .span = tree.span};
        fact.atom.predicate = id;
        fact.atom.span = tree.span;
        fact.atom.arguments.push_back(head_location(*tree.arguments[0]));
        for (std::size_t i = 1; i < p.arguments.size(); ++i) {
            Term any;
            any.type = p.arguments[i].type;
            any.span = tree.span;
            const std::string where = fmt::format("argument {} of `{}`", i + 1, name);
            fact.atom.arguments.push_back(i <= values ? scope_->resolve(*tree.arguments[i + 1], p.arguments[i].type, where) : any);
        }
        Head h{.kind = Head::Kind::Comprehension, .span = tree.span};
        h.body.push_back(std::move(fact));
        out.push_back(std::move(h));
    }
    if (!fits)
        report_.add(Kind::ArityMismatch, tree.span, fmt::format("no `{}` has so many arguments", name)).help =
            fmt::format("write `delete(A, {})` to consume all of its facts", name);
    if (tree_->arrow != syntax::Arrow::Linear)
        report_.add(Kind::OnlyConsuming, tree.span, "only a rule that consumes linear facts deletes others").help =
            "write the rule with -o and a linear fact in its body";
}

// The run would find out too, but late.
void Resolver::check_watched(const Term& name) {
    if (name.op != Op::String) return;
    std::vector<std::string> known;
    for (const Predicate& p : program_.predicates) {
        if (p.kind == PredicateKind::Action || p.world != WorldSource::None) continue;
        if (p.name == name.text) return;
        if (!p.prelude) known.push_back(p.name);
    }
    const std::string near = diagnostics::nearest_name(name.text, known);
    auto& d =
        report_.add(Kind::UnknownPredicate, name.span, fmt::format("there is no predicate `{}` whose facts can be watched", name.text));
    d.help = near.empty() ? "name a predicate of the program; what is read from the world is not stored"
                          : fmt::format("did you mean `{}`?", near);
    if (!near.empty()) d.fixes = {diagnostics::write(name.span, fmt::format("\"{}\"", near))};
}

// In ticks: the largest number that a double holds exactly, far below an overflow when added to the present tick.
constexpr double kLongestDelay = 0x1p53;

Term Resolver::delay(const syntax::Delay& tree) {
    Term ticks;
    ticks.type = Type::Int;
    ticks.span = tree.span;
    const bool whole = tree.unit == syntax::Delay::Unit::Ticks;
    if (!(tree.amount > 0) || (whole && tree.amount < 1)) {
        auto& d = report_.add(Kind::BadDelay, tree.span, "a delay is at least one tick");
        d.help = "leave it out, or write @+1 for the next tick";
        d.fixes = {diagnostics::leave_out(tree.span, "the delay", Fit::Exact), diagnostics::write(tree.span, "@+1")};
    }
    const bool fits = !whole || tree.amount <= kLongestDelay;
    if (!fits)
        report_.add(Kind::NumberOutOfRange, tree.span, "this delay does not fit").help =
            fmt::format("the longest has {:.0f} ticks", kLongestDelay);
    if (whole) {
        ticks.op = Op::Int;
        ticks.integer = fits ? static_cast<std::int64_t>(tree.amount) : 1;
        return ticks;
    }
    ticks.op = Op::Ticks;
    Term seconds;
    seconds.op = Op::Float;
    seconds.type = Type::Float;
    seconds.span = tree.span;
    seconds.real = tree.unit == syntax::Delay::Unit::Milliseconds ? tree.amount / 1000 : tree.amount;
    ticks.operands.push_back(std::move(seconds));
    return ticks;
}

void Resolver::rule_aggregate(const syntax::RuleAggregate& tree, Span span, std::vector<Head>& out) {
    Head h{.kind = Head::Kind::Aggregate, .span = span};
    {
        const Inside inside(*scope_, *locals_, &tree);
        h.body = body(tree.body);
        warn_of_one_value(tree.variables, &tree, h.body, "aggregate");
        h.heads = heads(tree.each);
        for (const syntax::HeadAggregate& one : tree.aggregates) {
            HeadAggregate made;
            Term value;
            if (one.op != "count") {
                made.each = scope_->variable(one.result.text, one.result.span);
                value = variable_term(made.each, one.result.span);
            }
            made.aggregate = aggregate(one.op, value, one.result.span);
            if (one.function.empty()) {
                made.parameter = aggregate_parameter(made.aggregate, one.parameter, one.op, one.result.span);
            } else if (one.parameter != nullptr) {
                const auto own = names_.functions.find(one.function);
                const Type wanted = own == names_.functions.end() ? type_of_library_fold(one.function, value.type).value_or(Type::Error)
                                                                  : program_.functions[own->second].result;
                made.parameter = scope_->resolve(*one.parameter, wanted, "what a fold starts from");
            }
            if (made.aggregate == Aggregate::Custom) {
                const std::optional<FunctionId> function =
                    fold_function(one.op == "custom" ? one.function : one.op, value,
                                  one.parameter != nullptr ? FoldStart::Given : FoldStart::FirstValue, one.result.span);
                if (!function) return;
                made.function = *function;
            }
            h.aggregates.push_back(std::move(made));
        }
    }
    const Inside inside(*scope_, *locals_, &tree.result);
    MELD_ASSERT(h.aggregates.size() == tree.aggregates.size(), "{} of {} aggregates", h.aggregates.size(), tree.aggregates.size());
    for (std::size_t i = 0; i < h.aggregates.size(); ++i) {
        const syntax::HeadAggregate& one = tree.aggregates[i];
        h.aggregates[i].result = scope_->variable(one.result.text, one.result.span);
        Variable& result = rule_->variables[h.aggregates[i].result];
        const Type value = h.aggregates[i].each.valid() ? rule_->variables[h.aggregates[i].each].type : Type::Int;
        if (result.type == Type::Error) result.type = type_of_aggregate(one.op == "custom" ? one.function : one.op, value);
    }
    h.others = heads(tree.result);
    out.push_back(std::move(h));
}

// One head of kind Set for each variable, the others inside it.
void Resolver::exists(const syntax::Exists& tree, Span span, std::vector<Head>& out) {
    const Inside inside(*scope_, *locals_, &tree);
    std::vector<Head> made = heads(tree.head);
    for (std::size_t i = tree.variables.size(); i-- > 0;) {
        const syntax::Name& name = tree.variables[i];
        Head h{.kind = Head::Kind::Set, .span = span};
        h.variable = scope_->variable(name.text, name.span);
        // One that no fact mentions makes nothing.
        Type& type = rule_->variables[h.variable].type;
        if (type == Type::Error) type = Type::Node;
        if (type != Type::Int && type != Type::Node)
            report_.add(Kind::TypeMismatch, name.span,
                        fmt::format("`exists` makes an int or a node, and `{}` is {}", name.text, check::type_name(type)));
        h.term.op = Op::Fresh;
        h.term.type = type;
        h.term.span = name.span;
        h.heads = std::move(made);
        made.clear();
        made.push_back(std::move(h));
    }
    for (Head& h : made) out.push_back(std::move(h));
}

Term Resolver::head_location(const syntax::Expr& e) {
    std::vector<Clause> tests;
    Term term = location(e, &tests);
    for (Clause& t : tests) rule_->body.push_back(std::move(t));
    return term;
}

}  // namespace meld::check
