// Pass 2: rules. Names become ids, terms get types, views with several heads become one rule a head.
// Assumes declare().
#include <algorithm>
#include <cctype>
#include <filesystem>

#include "compiler/check/rules/resolver.h"
#include "compiler/syntax/parse.h"
#include "runtime/base/assert.h"

namespace meld::check {

using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

namespace {

// The sign that an atom with one begins with.
Span sigil_of(Span atom) { return {atom.file, atom.begin, atom.begin + 1}; }

}  // namespace

void Resolver::rule(const syntax::Rule& tree) {
    MELD_EXPECT(tree.span.begin <= tree.span.end, "a rule from {} to {}", tree.span.begin, tree.span.end);
    errors_before_ = report_.error_count();
    refused_ = false;
    places_.clear();
    fixed_.clear();
    fixed_inside_.clear();
    hinted_.clear();
    tree_ = &tree;
    Rule rule;
    rule.span = tree.span;
    rule.line = files_.begin(tree.span).line;
    rule.file = std::filesystem::path(files_.file(tree.span).path()).filename().string();
    rule.text = syntax::print(tree);
    dialect_linear_ = linear_files_.contains(tree.span.file);
    Scope scope(program_, names_, rule, report_, !dialect_linear_);
    const LocalNames locals(tree, [&](const syntax::Expr& e) { return scope.variable_name(e); });
    scope_ = &scope;
    locals_ = &locals;
    rule_ = &rule;
    type_variables(tree.body);
    type_heads(tree.head);
    // A variable that the body leaves unbound, as in X = @arg1, may be bound by a head.
    for (const syntax::HeadItem& item : tree.head)
        if (const auto* fact = std::get_if<syntax::HeadFact>(&item.node)) type_from_atom(fact->atom);
    type_variables(tree.body);
    rule.body = body(tree.body);
    rule.heads = heads(tree.head);
    if (tree.selector) {
        rule.selected = scope.variable(tree.selector->variable.text, tree.selector->variable.span);
        using Order = syntax::Selector::Order;
        rule.select = tree.selector->order == Order::Random       ? Select::Random
                      : tree.selector->order == Order::Descending ? Select::Descending
                                                                  : Select::Ascending;
    }
    unify_fixed_catoms(rule);
    note_lower_case();
    finish(tree, rule);
}

void Resolver::finish(const syntax::Rule& tree, Rule& rule) {
    // A fact that is only read, with $p or in a test for its absence, is not consumed.
    if (tree.arrow == syntax::Arrow::Question) {
        rule.refused = refused_ || report_.error_count() > errors_before_;
        program_.questions.push_back(std::move(rule));
        return;
    }
    bool consumes = false;
    const Atom* read = nullptr;
    each_atom(rule.body, [&](const Atom& a, bool negated) {
        if (!program_.predicates[a.predicate].linear()) return;
        if (negated || a.read_only)
            read = &a;
        else
            consumes = true;
    });
    find_single_use(rule);
    if (refuse_linear_inside(rule.body, consumes ? Consumes::Yes : Consumes::No)) return;
    if (tree.arrow != syntax::Arrow::View && read != nullptr && !consumes) {
        const std::string& name = program_.predicates[read->predicate].name;
        auto& d = report_.add(Kind::InfiniteLinear, read->span,
                              fmt::format("`{}` is read here and nothing is consumed, so this rule would fire without end", name));
        d.help = "consume a linear fact in the body";
        if (read->read_only)
            d.help = "leave out `$`, and the rule consumes it";
        else if (read->arguments[0].is_variable())
            suggest_to_start_once(read->arguments[0].variable, d);
        if (read->read_only) d.fixes = {{.title = fmt::format("Consume `{}`", name), .edits = {{sigil_of(read->span), "", Fit::Word}}}};
        return;
    }
    const bool original = consumes && consumes_as_original(tree);
    if (original && consuming_note_ == nullptr) {
        consuming_note_ =
            &report_.add(Kind::ConsumingView, tree.span,
                         persistent_marked_ ? "this rule consumes linear facts, as in Linear Meld, where `:-` and -o mean the same"
                                            : "this rule consumes what it marks with `!`, as in original Meld");
        consuming_note_->help = "today one writes -o, and no sign before linear facts: `" + consuming(tree) + "`";
    }
    if (tree.arrow == syntax::Arrow::View && !original && (consumes || read != nullptr)) {
        auto& d = report_.add(Kind::LinearInView, rule.span, "a view holds while its body does, and a linear fact is there to be consumed");
        each_atom(rule.body, [&](const Atom& a, bool) {
            if (program_.predicates[a.predicate].linear()) d.labels.push_back({a.span, "this is linear"});
        });
        // A fact that is only read, or asked for its absence, would not be consumed by a rule with -o either.
        if (!consumes && !read->read_only) {
            d.help = fmt::format("a view can ask only for persistent facts: keep one while `{}` is there, and ask for that",
                                 program_.predicates[read->predicate].name);
            return;
        }
        std::string text = consuming(tree);
        if (const std::string sign = "$" + (read == nullptr ? "" : program_.predicates[read->predicate].name) + "("; !consumes)
            for (std::size_t at = text.find(sign); at != std::string::npos; at = text.find(sign)) text.erase(at, 1);
        d.help = "write the rule with -o: `" + text + "`";
        d.fixes = {diagnostics::write(tree.span, without_stop(text))};
        return;
    }
    if (tree.selector && !consumes) {
        report_
            .add(Kind::OnlyConsuming, tree.selector->variable.span,
                 "only a rule that consumes linear facts chooses among matches: a view holds for them all")
            .help = "for the least or greatest value, declare it with `min` or `max` in the head";
        return;
    }
    if (consumes) {
        rule.linear = true;
        place_counts(rule);
        add(std::move(rule));
        return;
    }
    views(rule, rule.body, rule.heads, rule.body.empty() || tree.arrow == syntax::Arrow::Axiom);
}

// Original Meld writes rules that consume with `:-`, and `!` before each fact that they consume. Where a program without -o marks
// persistent facts, as Linear Meld does, no sign stands before linear ones, and `:-` means -o there.
bool Resolver::consumes_as_original(const syntax::Rule& tree) const {
    if (tree.arrow != syntax::Arrow::View || dialect_linear_) return false;
    return std::ranges::all_of(tree.body, [&](const syntax::Clause& c) {
        const auto* atom = std::get_if<syntax::Atom>(&c.node);
        if (atom == nullptr) return true;
        const auto found = names_.predicates.find({atom->name.text, atom->arguments.size()});
        if (found == names_.predicates.end() || !program_.predicates[found->second].linear()) return true;
        return (atom->sigil == syntax::Sigil::Persistent) != persistent_marked_;
    });
}

// An aggregate in a body, or a delta, tests what holds and consumes nothing, so it may read only persistent facts. The body of a rule that
// consumes other facts may count linear facts, as it may test that there are none.
bool Resolver::refuse_linear_inside(const std::vector<Clause>& body, Consumes consumes) {
    const std::size_t errors = report_.error_count();
    bool may_count = consumes == Consumes::Yes;
    const auto visit = [&](const auto& self, const std::vector<Clause>& clauses, bool asked) -> void {
        for (const Clause& c : clauses) {
            const bool fact = c.kind == Clause::Kind::Delta || (asked && !may_count && c.kind == Clause::Kind::Atom);
            if (fact && program_.predicates[c.atom.predicate].linear())
                report_
                    .add(Kind::LinearInside, c.atom.span,
                         fmt::format("`{}` is linear, and would be read here without being consumed",
                                     program_.predicates[c.atom.predicate].name))
                    .help = "keep a persistent fact beside it, or consume the linear facts in the head: [count => N | | body | head]";
            self(self, c.inner, asked || c.kind == Clause::Kind::Aggregate);
        }
    };
    visit(visit, body, false);
    may_count = false;
    each_head(rule_->heads, [&](const Head& h) { visit(visit, h.body, false); });
    return report_.error_count() > errors;
}

// A body with the conditions of a head; these are recognized by their position.
static std::vector<Clause> with_head(std::vector<Clause> body, std::vector<Clause> more, const Head& head) {
    for (Clause& c : more) {
        if (c.kind == Clause::Kind::Test) c.span = head.span;
        body.push_back(std::move(c));
    }
    return body;
}

void Resolver::views(const Rule& rule, const std::vector<Clause>& body, const std::vector<Head>& heads, bool axiom) {
    for (const Head& h : heads) {
        const auto joined = [&](std::vector<Clause> more) { return with_head(body, std::move(more), h); };
        switch (h.kind) {
            case Head::Kind::Fact: {
                Rule one = rule;
                one.body = body;
                one.heads = {h};
                if (program_.predicates[h.atom.predicate].linear()) {
                    if (!axiom && !program_.predicates[h.atom.predicate].sensed) {
                        once(rule, body, h);
                        break;
                    }
                    one.linear = one.initial_fact = true;
                } else if (is_sent(body, h)) {
                    sent_view(rule, body, h);
                    break;
                }
                place_counts(one);
                add(std::move(one));
                break;
            }
            case Head::Kind::Comprehension:
                if (part_with_linear_facts(rule, body, h)) break;
                views(rule, joined(h.body), h.heads, false);
                break;
            case Head::Kind::Aggregate:
                if (part_with_linear_facts(rule, body, h)) break;
                view_of_aggregate(rule, body, h);
                break;
            case Head::Kind::If: {
                Term otherwise;
                otherwise.op = Op::Not;
                otherwise.type = Type::Bool;
                otherwise.span = h.term.span;
                otherwise.operands = {h.term};
                views(rule, joined({test(h.term)}), h.heads, axiom);
                views(rule, joined({test(std::move(otherwise))}), h.others, axiom);
                break;
            }
            case Head::Kind::Set:
                if (h.term.op != Op::Fresh) {
                    Term equation;
                    equation.op = Op::Equal;
                    equation.type = Type::Bool;
                    equation.span = h.span;
                    equation.operands = {variable_term(h.variable, h.span), h.term};
                    views(rule, joined({test(std::move(equation))}), h.heads, axiom);
                    break;
                }
                report_
                    .add(Kind::OnlyConsuming, h.span,
                         "only a rule that consumes linear facts makes new values: a view is evaluated again and again")
                    .help = "consume a linear fact in the body";
                return;
        }
    }
}

// [ sum => S | X | body | each | last ]: `each` for every match; `last` with S = sum X' : { body' }, a copy of the body with fresh
// variables for each of the aggregates.
void Resolver::view_of_aggregate(const Rule& rule, const std::vector<Clause>& body, const Head& head) {
    MELD_EXPECT(head.kind == Head::Kind::Aggregate, "a head that aggregates nothing");
    views(rule, with_head(body, head.body, head), head.heads, false);
    Variables outside;
    for (const Clause& c : body) each_variable(c, [&](VariableId v) { outside.insert(v); });
    Rule last = rule;
    std::vector<Clause> clauses = body;
    for (const HeadAggregate& one : head.aggregates) {
        MELD_ASSERT(one.result.valid() && one.result.index() < rule.variables.count(), "an aggregate without a result");
        Clause c{.kind = Clause::Kind::Aggregate,
                 .inner = head.body,
                 .variable = one.result,
                 .aggregate = one.aggregate,
                 .fold = one.function,
                 .parameter = one.parameter,
                 .span = head.span};
        if (one.each.valid()) {
            c.test.op = Op::Variable;
            c.test.type = rule.variables[one.each].type;
            c.test.variable = one.each;
            c.test.span = head.span;
        }
        std::map<VariableId, VariableId> own;
        const auto rename = [&](VariableId& v) {
            if (!v.valid() || outside.contains(v)) return;
            if (!own.contains(v)) own[v] = last.variables.add(last.variables[v]);
            v = own[v];
        };
        for (Clause& inner : c.inner) rewrite_variables(inner, rename);
        rewrite_variables(c.test, rename);
        clauses.push_back(std::move(c));
    }
    views(last, clauses, head.others, false);
}

// proved(N, p) counts at the execution site: the catom of a view's head, or of the facts that are consumed.
void Resolver::place_counts(Rule& rule) const {
    MELD_EXPECT(rule.linear || rule.heads.size() == 1, "a view with {} heads", rule.heads.size());
    const Atom* at_site = nullptr;
    if (!rule.linear) at_site = &rule.heads[0].atom;
    for (const Clause& c : rule.body)
        if (rule.linear && at_site == nullptr && c.kind == Clause::Kind::Atom && program_.predicates[c.atom.predicate].linear())
            at_site = &c.atom;
    if (at_site == nullptr) return;
    const Term place = at_site->arguments[0];
    const auto visit = [&](const auto& self, std::vector<Clause>& body) -> void {
        for (Clause& c : body) {
            if (c.kind == Clause::Kind::Atom && !c.atom.arguments[0].is_variable()) c.atom.arguments[0] = place;
            self(self, c.inner);
        }
    };
    const auto visit_heads = [&](const auto& self, std::vector<Head>& heads) -> void {
        for (Head& h : heads) {
            visit(visit, h.body);
            self(self, h.heads);
            self(self, h.others);
        }
    };
    visit(visit, rule.body);
    visit_heads(visit_heads, rule.heads);
}

std::string Resolver::consuming(const syntax::Rule& tree) const {
    std::string text = syntax::print(tree);
    for (const Predicate& p : program_.predicates) {
        if (!p.linear()) continue;
        const std::string signed_name = "!" + p.name + "(";
        for (std::size_t at = text.find(signed_name); at != std::string::npos; at = text.find(signed_name, at)) text.erase(at, 1);
    }
    const std::size_t arrow = text.find(":-");
    if (arrow == std::string::npos) return text;
    std::string head = text.substr(0, arrow), body = text.substr(arrow + 2);
    const auto trim = [](std::string s) {
        while (!s.empty() && (s.back() == ' ' || s.back() == '.' || s.back() == '\n')) s.pop_back();
        while (!s.empty() && s.front() == ' ') s.erase(s.begin());
        return s;
    };
    return trim(body) + " -o " + trim(head) + ".";
}

void Resolver::finish() const {
    MELD_CHECK(!lost_ || report_.has_errors(), "a rule was left out without a message");
    later_.finish();
}

void Resolver::add(Rule rule) {
    if (refused_ || report_.error_count() > errors_before_) {
        lost_ = true;
        return;
    }
    MELD_ASSERT(rule.line > 0 && !rule.text.empty(), "a rule that stands nowhere");
    std::string head = rule.heads.empty()                       ? "nothing"
                       : rule.heads[0].kind == Head::Kind::Fact ? program_.predicates[rule.heads[0].atom.predicate].name
                                                                : "all";
    rule.name = fmt::format("{}@{}", head, rule.line);
    const int twin = ++rules_named_[rule.name];
    if (twin > 1) rule.name += fmt::format(".{}", twin);
    each_head(rule.heads, [&](const Head& h) {
        const PredicateId p = h.atom.predicate;
        if (h.kind == Head::Kind::Fact && std::find(rule.derives.begin(), rule.derives.end(), p) == rule.derives.end())
            rule.derives.push_back(p);
    });
    program_.rules.add(std::move(rule));
}

// A linear fact that every catom has from the start lets the rule fire once.
void Resolver::suggest_to_start_once(VariableId place, diagnostics::Diagnostic& d) const {
    const std::string& at = rule_->variables[place].name;
    if (at.empty() || at[0] == '_' || tree_->selector) return;
    std::string once = "start";
    for (const char* name : {"start", "begin", "once"})
        if (once = name; !names_.predicates.contains({once, 1})) break;
    const std::string declaration = fmt::format("type linear {}(node).", once), fact = fmt::format("{}({}).", once, at),
                      rule = fmt::format("{}({}), {}", once, at, consuming(*tree_));
    d.help = fmt::format("consume a linear fact in the body, such as one that each catom has at the start:\n`{}`, `{}`, and `{}`",
                         declaration, fact, rule);
    d.fixes = {{.title = fmt::format("Fire once, with a fact `{}` of each catom", once),
                .edits = {later_.declaration(tree_->span, declaration), {tree_->span, fmt::format("{}\n{}", fact, without_stop(rule))}}}};
}

void Resolver::find_single_use(Rule& rule) const {
    if (rule.body.empty()) return;  // p(A): at every catom.
    // A rule that only consumes need not mention its catom otherwise.
    Variables places;
    if (rule.heads.empty())
        for (const Clause& c : rule.body)
            if (c.kind == Clause::Kind::Atom) places.insert(c.atom.arguments[0].variable);
    std::vector<int> uses(rule.variables.count(), 0);
    const auto count = [&](VariableId v) { ++uses[v.index()]; };
    for (const Clause& c : rule.body) each_variable(c, count);
    for (const Head& h : rule.heads) each_variable(h, count);
    if (rule.selected.valid()) count(rule.selected);
    for (const VariableId v : hinted_) count(v);
    for (const VariableId id : rule.variables.ids())
        if (uses[id.index()] == 1 && !places.contains(id) && !rule.variables[id].name.starts_with("_")) rule.used_once.push_back(id);
}

void Resolver::note_lower_case() {
    if (dialect_linear_) return;
    std::set<std::string> small;
    for (const Variable& v : rule_->variables) {
        if (v.name.empty() || !std::islower(static_cast<unsigned char>(v.name[0]))) continue;
        small.insert(v.name);
        if (lower_case_note_ != nullptr) continue;
        lower_case_note_ =
            &report_.add(Kind::LowerCaseVariable, v.span, fmt::format("`{}` is read as a variable, as in original Meld", v.name));
        lower_case_note_->help = "variables start with a capital";
    }
    if (!small.empty()) later_.add_small_variables(*lower_case_note_, tree_->span, std::move(small));
}

void resolve_rules(const source::FileSet& files, const syntax::Tree& tree, Program& program, diagnostics::Reporter& report) {
    std::set<std::uint32_t> linear_files;
    for (const syntax::Item& item : tree.items)
        if (const auto* rule = std::get_if<syntax::Rule>(&item);
            rule != nullptr && (rule->arrow == syntax::Arrow::Linear || rule->arrow == syntax::Arrow::Question))
            linear_files.insert(rule->span.file);
    const Names names(program, tree);
    Resolver resolver(files, names, program, report, std::move(linear_files));
    resolver.find_signs();
    for (const syntax::Item& item : tree.items)
        if (const auto* rule = std::get_if<syntax::Rule>(&item))
            resolver.rule(*rule);
        else if (const auto* hint = std::get_if<syntax::Hint>(&item))
            resolver.priorities_of_all(*hint);
    resolver.finish();
    for (const Constant& c : program.constants)
        if (c.argument && has_unknown(c.type) && !report.has_errors())
            report.add(Kind::BadConstant, c.span, fmt::format("nothing here determines the type of `@{}`", c.name)).help =
                "make it an argument of a fact or function, or compare it with a value of its type";
}

}  // namespace meld::check
