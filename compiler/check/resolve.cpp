// Pass 2: rules. Names become ids, terms get types, views with several heads become one rule a head.
// Assumes declare(). What a clause of the language means but this version does not compile is refused by name.
#include <algorithm>
#include <set>

#include "compiler/check/check.h"
#include "compiler/check/scope.h"
#include "compiler/syntax/parse.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

class Resolver {
  public:
    Resolver(const source::FileSet& files, const Names& names, Program& program, diagnostics::Reporter& report, std::set<std::uint32_t> linear_files)
        : files_(files), names_(names), program_(program), report_(report), linear_files_(std::move(linear_files)) {}

    void rule(const syntax::Rule& tree) {
        if (tree.selector) {
            not_yet(tree.span, "selectors");
            return;
        }
        errors_before_ = report_.error_count();
        refused_ = false;
        Rule rule;
        rule.span = tree.span;
        rule.line = files_.begin(tree.span).line;
        rule.text = syntax::print(tree);
        dialect_linear_ = linear_files_.contains(tree.span.file);
        Scope scope(program_, names_, rule, report_, !dialect_linear_);
        scope_ = &scope;
        rule_ = &rule;
        type_variables(tree.body);
        for (const syntax::HeadItem& head : tree.head) type_comprehension(head);
        rule.body = body(tree.body);
        for (const syntax::HeadItem& item : tree.head) head(item, rule.heads);
        if (!lower_case_noted_) note_lower_case();
        finish(tree, rule);
    }

  private:
    void not_yet(Span span, const std::string& what) { report_.add(Kind::NotSupportedYet, span, what + " are not compiled by this version"); }

    // ---- types of variables, before any term is built: from atoms first, then from equalities

    void type_variables(const std::vector<syntax::Clause>& clauses) {
        type_from_atoms(clauses);
        for (bool changed = true; changed;) {
            changed = false;
            type_from_equalities(clauses, changed);
        }
    }
    void type_comprehension(const syntax::HeadItem& item) {
        if (const auto* c = std::get_if<syntax::Comprehension>(&item.node)) {
            type_variables(c->body);
            for (const syntax::HeadItem& inner : c->head) type_comprehension(inner);
        }
    }
    void type_from_atoms(const std::vector<syntax::Clause>& clauses) {
        for (const syntax::Clause& clause : clauses) {
            if (const auto* atom = std::get_if<syntax::Atom>(&clause.node)) type_from_atom(*atom);
            if (const auto* negated = std::get_if<syntax::Not>(&clause.node)) type_from_atoms(negated->clauses);
            if (const auto* all = std::get_if<syntax::Forall>(&clause.node)) {
                type_from_atom(all->atom);
                type_from_atoms(all->clauses);
            }
        }
    }
    void type_from_atom(const syntax::Atom& atom) {
        const auto found = names_.predicates.find({atom.name.text, atom.arguments.size()});
        if (found == names_.predicates.end()) return;
        const Predicate& p = program_.predicates[found->second];
        for (std::size_t i = 0; i < atom.arguments.size(); ++i) scope_->spread_type(*atom.arguments[i], p.arguments[i].type);
    }
    void type_from_equalities(const std::vector<syntax::Clause>& clauses, bool& changed) {
        for (const syntax::Clause& clause : clauses) {
            if (const auto* negated = std::get_if<syntax::Not>(&clause.node)) type_from_equalities(negated->clauses, changed);
            if (const auto* all = std::get_if<syntax::Forall>(&clause.node)) type_from_equalities(all->clauses, changed);
            const auto* test = std::get_if<syntax::Constraint>(&clause.node);
            const auto* equal = test ? std::get_if<syntax::Binary>(&test->condition->node) : nullptr;
            if (equal == nullptr || equal->op != syntax::BinaryOp::Equal) continue;
            changed = scope_->spread_type(*equal->left, scope_->infer(*equal->right)) || changed;
            changed = scope_->spread_type(*equal->right, scope_->infer(*equal->left)) || changed;
        }
    }

    // ---- bodies

    std::vector<Clause> body(const std::vector<syntax::Clause>& clauses) {
        std::vector<Clause> out;
        for (const syntax::Clause& clause : clauses) this->clause(clause, out);
        return out;
    }

    void clause(const syntax::Clause& tree, std::vector<Clause>& out) {
        if (const auto* a = std::get_if<syntax::Atom>(&tree.node)) {
            body_atom(*a, out);
        } else if (const auto* t = std::get_if<syntax::Constraint>(&tree.node)) {
            condition(*t->condition, out);
        } else if (const auto* n = std::get_if<syntax::Not>(&tree.node)) {
            Clause c{.kind = Clause::Kind::Not, .span = tree.span};
            c.inner = body(n->clauses);
            out.push_back(std::move(c));
        } else if (const auto* f = std::get_if<syntax::Forall>(&tree.node)) {
            // What holds for all holds where there is no exception.
            Clause exception{.kind = Clause::Kind::Not, .span = tree.span};
            exception.inner = body(f->clauses);
            Clause c{.kind = Clause::Kind::Not, .span = tree.span};
            body_atom(f->atom, c.inner);
            c.inner.push_back(std::move(exception));
            out.push_back(std::move(c));
        } else {
            not_yet(tree.span, std::holds_alternative<syntax::Element>(tree.node)  ? "lists"
                               : std::holds_alternative<syntax::Delta>(tree.node)  ? "delta conditions"
                               : std::holds_alternative<syntax::Proved>(tree.node) ? "proved conditions"
                                                                                   : "body aggregates");
        }
    }

    // An equality with a pattern makes or takes apart; what it is compared with is a variable, made if need be.
    void condition(const syntax::Expr& e, std::vector<Clause>& out) {
        const auto* equal = std::get_if<syntax::Binary>(&e.node);
        const bool patterns = equal != nullptr && equal->op == syntax::BinaryOp::Equal && (scope_->is_pattern(*equal->left) || scope_->is_pattern(*equal->right));
        const std::optional<Type> common = patterns ? join(scope_->infer(*equal->left), scope_->infer(*equal->right)) : std::nullopt;
        // Types that do not go together are reported where they are compared.
        if (!common) {
            out.push_back(test(scope_->resolve(e, Type::Bool, "a condition")));
            return;
        }
        const bool left = scope_->is_pattern(*equal->left);
        const syntax::Expr &pattern = left ? *equal->left : *equal->right, &other = left ? *equal->right : *equal->left;
        std::vector<Clause> tests;
        Term value = scope_->is_pattern(other) ? scope_->pattern_variable(other, *common, tests) : scope_->resolve(other, *common, "`=`");
        if (!value.is_variable()) {
            Term variable{.op = Op::Variable, .type = value.type, .span = other.span, .variable = scope_->fresh("_value", value.type, other.span)};
            tests.push_back(equality(variable, std::move(value), e.span));
            value = variable;
        }
        const std::size_t at = tests.size();
        Term made = scope_->pattern(pattern, *common, tests);
        tests.insert(tests.begin() + static_cast<std::ptrdiff_t>(at), equality(std::move(value), std::move(made), e.span));
        for (Clause& t : tests) out.push_back(std::move(t));
    }

    static Clause test(Term term) {
        Clause c{.kind = Clause::Kind::Test};
        c.span = term.span;
        c.test = std::move(term);
        return c;
    }

    // The catom of an atom is always a variable: another expression there becomes a fresh one and a test.
    Term location(const syntax::Expr& e, std::vector<Clause>* tests) {
        if (scope_->variable_name(e) != nullptr) return scope_->resolve(e, Type::Node, "the place of a fact");
        Term term;
        term.op = Op::Variable;
        term.type = Type::Node;
        term.span = e.span;
        if (std::holds_alternative<syntax::Anonymous>(e.node)) {
            term.variable = scope_->fresh("_", Type::Node, e.span);
            return term;
        }
        Term value = scope_->resolve(e, Type::Node, "the place of a fact");
        term.variable = scope_->fresh("_at", Type::Node, e.span);
        if (tests != nullptr) {
            tests->push_back(equality(term, std::move(value), e.span));
        }
        return term;
    }

    std::optional<PredicateId> find(const syntax::Atom& atom) {
        const auto found = names_.predicates.find({atom.name.text, atom.arguments.size()});
        if (found != names_.predicates.end()) {
            if (!program_.predicates[found->second].refused) return found->second;
            refused_ = true;
            return std::nullopt;
        }
        if (names_.tree.is_lost(atom.name.text)) {
            refused_ = true;
            return std::nullopt;
        }
        for (const auto& [key, id] : names_.predicates)
            if (key.first == atom.name.text) {
                const std::size_t needs = program_.predicates[id].arguments.size();
                report_.add(Kind::ArityMismatch, atom.span, fmt::format("`{}` has {} argument{}, and here {} {}", atom.name.text, needs, needs == 1 ? "" : "s",
                                                                       atom.arguments.size() == 1 ? "is" : "are", atom.arguments.size()))
                    .labels = {{program_.predicates[id].span, "declared here"}};
                return std::nullopt;
            }
        std::vector<std::string> known;
        for (const auto& [key, id] : names_.predicates) known.push_back(key.first);
        const std::string near = diagnostics::nearest_name(atom.name.text, known);
        report_.add(Kind::UnknownPredicate, atom.name.span, fmt::format("there is no predicate `{}`", atom.name.text)).help =
            near.empty() ? fmt::format("declare it: `type {}(node{}).`", atom.name.text, atom.arguments.size() > 1 ? ", ..." : "") : fmt::format("did you mean `{}`?", near);
        return std::nullopt;
    }

    void body_atom(const syntax::Atom& tree, std::vector<Clause>& out) {
        const std::optional<PredicateId> id = find(tree);
        if (!id) return visit_anyway(tree);
        const Predicate& p = program_.predicates[*id];
        sigil(tree, p);
        if (p.kind == PredicateKind::Action)
            report_.add(Kind::ActionInBody, tree.span, fmt::format("`{}` is an action, a request; it cannot be read", p.name)).help = "read the facts that lead to it";
        Clause c{.kind = Clause::Kind::Atom, .span = tree.span};
        c.atom.predicate = *id;
        c.atom.span = tree.span;
        c.atom.read_only = tree.sigil == syntax::Sigil::Read;
        std::vector<Clause> tests;
        for (std::size_t i = 0; i < tree.arguments.size(); ++i) {
            const std::string where = fmt::format("argument {} of `{}`", i + 1, p.name);
            if (i == 0) c.atom.arguments.push_back(location(*tree.arguments[i], &tests));
            else if (scope_->is_pattern(*tree.arguments[i])) c.atom.arguments.push_back(scope_->pattern_variable(*tree.arguments[i], p.arguments[i].type, tests));
            else c.atom.arguments.push_back(scope_->resolve(*tree.arguments[i], p.arguments[i].type, where, true, p.span));
        }
        out.push_back(std::move(c));
        for (Clause& t : tests) out.push_back(std::move(t));
    }

    // So that variables of an atom that was refused do not count as unbound.
    void visit_anyway(const syntax::Atom& tree) {
        for (const auto& argument : tree.arguments)
            if (const std::string* name = scope_->variable_name(*argument)) scope_->variable(*name, argument->span);
    }

    void sigil(const syntax::Atom& tree, const Predicate& p) {
        using syntax::Sigil;
        if (!dialect_linear_ && tree.sigil == Sigil::Persistent) return;  // Original Meld's mark of linear facts.
        const bool wrong = (tree.sigil == Sigil::Persistent && p.linear()) || ((tree.sigil == Sigil::Linear || tree.sigil == Sigil::Read) && !p.linear());
        if (!wrong) return;
        auto& d = report_.add(Kind::SigilMismatch, tree.span, fmt::format("`{}` is declared {}, and the sign before it says otherwise", p.name, p.linear() ? "linear" : "persistent"));
        d.labels = {{p.span, "declared here"}};
        d.help = fmt::format("write `{}({})`", p.name, tree.arguments.size() > 1 ? "..." : "A");
    }

    // ---- heads

    void head(const syntax::HeadItem& item, std::vector<Head>& out) {
        if (std::holds_alternative<syntax::Nothing>(item.node)) return;
        if (const auto* f = std::get_if<syntax::HeadFact>(&item.node)) {
            if (f->delay) not_yet(f->delay->span, "delays");
            head_fact(f->atom, out);
        } else if (const auto* c = std::get_if<syntax::Comprehension>(&item.node)) {
            Head h{.kind = Head::Kind::Comprehension, .span = item.span};
            h.body = body(c->body);
            for (const syntax::HeadItem& inner : c->head) head(inner, h.heads);
            out.push_back(std::move(h));
        } else {
            not_yet(item.span, std::holds_alternative<syntax::RuleAggregate>(item.node) ? "aggregates in heads"
                               : std::holds_alternative<syntax::Exists>(item.node)      ? "exists heads"
                                                                                        : "conditional heads");
        }
    }

    void head_fact(const syntax::Atom& tree, std::vector<Head>& out) {
        const std::optional<PredicateId> id = find(tree);
        if (!id) return visit_anyway(tree);
        const Predicate& p = program_.predicates[*id];
        sigil(tree, p);
        if (p.sensed)
            report_.add(Kind::DerivedSensed, tree.span, fmt::format("`{}` is sensed: the runtime alone says where it holds", p.name)).help =
                "derive a predicate of your own";
        Head h{.kind = Head::Kind::Fact, .span = tree.span};
        h.atom.predicate = *id;
        h.atom.span = tree.span;
        for (std::size_t i = 0; i < tree.arguments.size(); ++i) {
            const bool counted = p.aggregate == Aggregate::Count && p.aggregate_at == i;
            if (i == 0) h.atom.arguments.push_back(head_location(*tree.arguments[i]));
            else if (counted) h.atom.arguments.push_back(scope_->resolve(*tree.arguments[i], Type::Error, "a count"));
            else h.atom.arguments.push_back(scope_->resolve(*tree.arguments[i], p.arguments[i].type, fmt::format("argument {} of `{}`", i + 1, p.name), false, p.span));
        }
        out.push_back(std::move(h));
    }

    Term head_location(const syntax::Expr& e) {
        std::vector<Clause> tests;
        Term term = location(e, &tests);
        for (Clause& t : tests) rule_->body.push_back(std::move(t));
        return term;
    }

    // ---- the whole rule

    void finish(const syntax::Rule& tree, Rule& rule) {
        // What is read, with $p or to see that it is absent, stays.
        bool consumes = false;
        const Atom* read = nullptr;
        each_atom(rule.body, [&](const Atom& a, bool negated) {
            if (!program_.predicates[a.predicate].linear()) return;
            if (negated || a.read_only) read = &a;
            else consumes = true;
        });
        find_single_use(rule);
        const auto head_linear = [&](const Head& h) { return h.kind == Head::Kind::Comprehension || program_.predicates[h.atom.predicate].linear(); };
        if (tree.arrow != syntax::Arrow::View && read != nullptr && !consumes) {
            report_.add(Kind::InfiniteLinear, read->span, fmt::format("`{}` is read here and nothing is consumed, so this rule would be applied without end", program_.predicates[read->predicate].name)).help =
                "consume a linear fact in the body";
            return;
        }
        if (tree.arrow == syntax::Arrow::View && (consumes || read != nullptr)) {
            auto& d = report_.add(Kind::LinearInView, rule.span, "a view holds while its body does, and a linear fact is there to be consumed");
            each_atom(rule.body, [&](const Atom& a, bool) {
                if (program_.predicates[a.predicate].linear()) d.labels.push_back({a.span, "this is linear"});
            });
            d.help = "write the rule with -o: `" + swapped(tree) + "`";
            return;
        }
        const bool axiom = rule.body.empty() || tree.arrow == syntax::Arrow::Axiom;
        if (!consumes) {
            for (const Head& h : rule.heads) {
                if (!head_linear(h)) continue;
                if (h.kind == Head::Kind::Comprehension) {
                    report_.add(Kind::NotSupportedYet, h.span, "a comprehension in a view is not compiled by this version").help = "write a rule of its own: `head :- body.`";
                    return;
                }
                if (!axiom) {
                    report_.add(Kind::InfiniteLinear, h.span, fmt::format("nothing is consumed here, so `{}` would be made without end", program_.predicates[h.atom.predicate].name))
                        .help = "consume a linear fact in the body";
                    return;
                }
            }
        }
        if (consumes) {
            rule.linear = true;
            add(std::move(rule));
            return;
        }
        // A view: one rule a head. An axiom of a linear fact is given once, at birth.
        for (const Head& h : rule.heads) {
            Rule one = rule;
            one.heads = {h};
            if (program_.predicates[h.atom.predicate].linear()) one.linear = one.birth = true;
            add(std::move(one));
        }
    }

    static std::string swapped(const syntax::Rule& tree) {
        const std::string text = syntax::print(tree);
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

    void add(Rule rule) {
        if (refused_ || report_.error_count() > errors_before_) return;
        std::string head = rule.heads.empty() ? "nothing" : rule.heads[0].kind == Head::Kind::Fact ? program_.predicates[rule.heads[0].atom.predicate].name : "all";
        rule.name = fmt::format("{}@{}", head, rule.line);
        int twin = 1;
        for (const Rule& other : program_.rules)
            if (other.name == rule.name || other.name.starts_with(rule.name + ".")) ++twin;
        if (twin > 1) rule.name += fmt::format(".{}", twin);
        program_.rules.add(std::move(rule));
    }

    static void find_single_use(Rule& rule) {
        std::vector<int> uses(rule.variables.count(), 0);
        const auto count = [&](VariableId v) { ++uses[v.index()]; };
        for (const Clause& c : rule.body) each_variable(c, count);
        count_heads(rule.heads, count);
        for (const VariableId id : rule.variables.ids()) {
            const Variable& v = rule.variables[id];
            if (uses[id.index()] != 1 || v.name.starts_with("_")) continue;
            if (rule.body.empty()) continue;  // p(A): at every catom.
            rule.used_once.push_back(id);
        }
    }
    template <class Count>
    static void count_heads(const std::vector<Head>& heads, const Count& count) {
        for (const Head& h : heads) {
            for (const Term& t : h.atom.arguments) each_variable(t, count);
            for (const Clause& c : h.body) each_variable(c, count);
            count_heads(h.heads, count);
        }
    }

    void note_lower_case() {
        if (dialect_linear_) return;
        for (const Variable& v : rule_->variables)
            if (!v.name.empty() && std::islower(static_cast<unsigned char>(v.name[0]))) {
                report_.add(Kind::LowerCaseVariable, v.span, fmt::format("`{}` is read as a variable, as in original Meld", v.name)).help = "variables start with a capital";
                lower_case_noted_ = true;
                return;
            }
    }

    const source::FileSet& files_;
    const Names& names_;
    Program& program_;
    diagnostics::Reporter& report_;
    std::set<std::uint32_t> linear_files_;
    Scope* scope_ = nullptr;
    Rule* rule_ = nullptr;
    bool dialect_linear_ = false;
    std::size_t errors_before_ = 0;
    // The rule uses a predicate whose declaration was refused.
    bool refused_ = false;
    bool lower_case_noted_ = false;
};

}  // namespace

void resolve_rules(const source::FileSet& files, const syntax::Tree& tree, Program& program, diagnostics::Reporter& report) {
    std::set<std::uint32_t> linear_files;
    for (const syntax::Item& item : tree.items)
        if (const auto* rule = std::get_if<syntax::Rule>(&item); rule != nullptr && rule->arrow == syntax::Arrow::Linear) linear_files.insert(rule->span.file);
    const Names names(program, tree);
    Resolver resolver(files, names, program, report, std::move(linear_files));
    for (const syntax::Item& item : tree.items)
        if (const auto* rule = std::get_if<syntax::Rule>(&item)) resolver.rule(*rule);
}

}  // namespace meld::check
