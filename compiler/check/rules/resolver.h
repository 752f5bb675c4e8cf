// The state of pass 2: turns one rule at a time from syntax tree into a checked rule. Used only by the resolve*.cpp files.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <span>

#include "compiler/check/check.h"
#include "compiler/check/names/later_fixes.h"
#include "compiler/check/names/local_names.h"
#include "compiler/check/names/scope.h"

namespace meld::check {

class Resolver {
  public:
    Resolver(const source::FileSet& files, const Names& names, Program& program, diagnostics::Reporter& report,
             std::set<std::uint32_t> linear_files)
        : files_(files), names_(names), program_(program), report_(report), linear_files_(std::move(linear_files)), later_(files, names) {}

    // Before the first rule.
    void find_signs();
    void rule(const syntax::Rule& tree);
    void priorities_of_all(const syntax::Hint& hint);
    // After the last rule.
    void finish() const;

  private:
    // ---- types of variables, before any term is built: from atoms first, then from equalities (resolve_types.cpp)
    void type_variables(const std::vector<syntax::Clause>& clauses);
    void type_heads(const std::vector<syntax::HeadItem>& heads);
    void type_rule_aggregate(const syntax::RuleAggregate& aggregate);
    void type_fresh(const std::vector<syntax::HeadItem>& heads);
    void type_from_atoms(const std::vector<syntax::Clause>& clauses);
    void type_from_atom(const syntax::Atom& atom);
    void type_from_equalities(const std::vector<syntax::Clause>& clauses, bool& changed);
    void type_name(const syntax::Name& variable, const Type& type, bool& changed);
    Type type_of_aggregate(const std::string& op, const Type& value) const;

    // ---- bodies (resolve_body.cpp)
    std::vector<Clause> body(const std::vector<syntax::Clause>& clauses);
    void clause(const syntax::Clause& tree, std::vector<Clause>& out);
    // An equality with a pattern builds or takes apart a value; the other side is a variable, made if necessary.
    bool is_predicate(const std::string& name) const;
    // All predicates of a name that stands alone. What the world senses under it is not meant where the program has its own.
    std::vector<PredicateId> predicates_named(const std::string& name) const;
    void condition(const syntax::Expr& e, std::vector<Clause>& out);
    void body_atom(const syntax::Atom& tree, std::vector<Clause>& out);
    void body_aggregate(const syntax::BodyAggregate& tree, Span span, std::vector<Clause>& out);
    void delta(const syntax::Delta& tree, Span span, std::vector<Clause>& out);
    void element(const syntax::Element& tree, Span span, std::vector<Clause>& out);
    void proved(const syntax::Proved& tree, Span span, std::vector<Clause>& out);
    // The aggregate over matches that this word means; Custom: a function of the program.
    Aggregate aggregate_named(const std::string& op) const;
    // The same; reports values that it cannot aggregate.
    Aggregate aggregate(const std::string& op, const Term& value, Span span);
    // The number of values that min_k and max_k keep; Anonymous for all other aggregates.
    Term aggregate_parameter(Aggregate aggregate, const syntax::ExprPtr& number, const std::string& op, Span span);
    enum class FoldStart { Given, FirstValue };
    std::optional<FunctionId> fold_function(const std::string& name, const Term& value, FoldStart start, Span span);
    void report_without_value(const Term& folded);
    static Clause test(Term term);
    Term variable_term(VariableId id, Span span) const;
    // The catom of an atom is always a variable: another expression there becomes a fresh one and a test.
    Term location(const syntax::Expr& e, std::vector<Clause>* tests);

    // ---- catoms that the rule names (fixed_catoms.cpp)

    // The value of an expression that says where facts are, and the variable that stands for it.
    struct Place {
        Term value;
        VariableId variable;
    };
    // Whether the catom is known without the facts of the rule: @3, or a constant. It is one variable everywhere in the rule.
    static bool is_fixed(const Term& value);
    // Its place, or null.
    const Place* fixed_place(const Term& value) const;
    // Its variable, made on first use, with its test among these.
    VariableId variable_of_fixed(Term value, std::vector<Clause>& tests);
    void unify_fixed_catoms(Rule& rule);
    void name_far_ends(Rule& rule);
    void use_given_names(Rule& rule);

    // So that variables of an atom with an error do not count as unbound.
    void visit_anyway(const syntax::Atom& tree);

    // ---- variables that are thought to vary and do not (resolve_outside.cpp)
    void warn_of_one_value(const syntax::BodyAggregate& tree, const Term& value, const std::vector<Clause>& inner);
    // The list of variables of a part with this body.
    void warn_of_one_value(const std::vector<syntax::Name>& variables, const void* part, const std::vector<Clause>& body,
                           std::string_view of);

    // ---- names of predicates (resolve_predicates.cpp)
    enum class Part { Body, Head };
    std::optional<PredicateId> find(const syntax::Atom& atom, Part part);
    struct Unknown {
        diagnostics::Diagnostic& message;
        bool may_be_declared;  // `stable` and `terminate` mean something else.
    };
    Unknown unknown_predicate(const syntax::Name& name, std::optional<std::size_t> arguments, Part part);
    bool cure_of_another_machine(const syntax::Name& name, std::optional<std::size_t> arguments, Part part,
                                 diagnostics::Diagnostic& d) const;
    std::string nearest_predicate(const std::string& name, std::optional<std::size_t> arguments, Part part) const;
    std::string declared_names() const;
    // Whether the rule must consume this fact of its body, because it consumes nothing else that is known.
    LaterFixes::Consumed consumed(const syntax::Atom& atom, Part part) const;
    void suggest_more_arguments(const syntax::Atom& atom, diagnostics::Diagnostic& d) const;
    void sigil(const syntax::Atom& tree, const Predicate& p);
    void not_a_negation(const syntax::Atom& tree, const Predicate& p);

    // ---- heads (resolve_heads.cpp)
    std::vector<Head> heads(std::span<const syntax::HeadItem> items);
    Head head_let(const syntax::HeadLet& tree, std::span<const syntax::HeadItem> behind);
    void head(const syntax::HeadItem& item, std::vector<Head>& out);
    void head_fact(const syntax::HeadFact& item, std::vector<Head>& out);
    void derive_own_instead(const syntax::Atom& tree, const Predicate& p);
    Term one_element(const Predicate& p, const syntax::Expr& e);
    bool is_scheduling(const syntax::Atom& tree) const;
    void note_scheduling(const syntax::Atom& tree);
    bool is_deletion(const syntax::Atom& tree) const;
    void deletion(const syntax::Atom& tree, std::vector<Head>& out);

    // ---- priorities, for clocks that give turns (resolve_priorities.cpp)
    std::optional<PredicateId> action_of_clock(const syntax::Atom& tree) const;
    const syntax::Expr& asker(const syntax::Atom& tree) const;
    void ask_clock(const syntax::Atom& tree, PredicateId id, std::vector<Head>& out);

    void check_watched(const Term& name);
    void rule_aggregate(const syntax::RuleAggregate& tree, Span span, std::vector<Head>& out);
    void exists(const syntax::Exists& tree, Span span, std::vector<Head>& out);
    Term delay(const syntax::Delay& tree);
    Term head_location(const syntax::Expr& e);

    // ---- the whole rule (resolve.cpp)
    void finish(const syntax::Rule& tree, Rule& rule);
    bool consumes_as_original(const syntax::Rule& tree) const;
    enum class Consumes { No, Yes };
    bool refuse_linear_inside(const std::vector<Clause>& body, Consumes consumes);
    // Views: every head becomes a separate rule, and the heads around it add to its body.
    void views(const Rule& rule, const std::vector<Clause>& body, const std::vector<Head>& heads, bool axiom);
    void view_of_aggregate(const Rule& rule, const std::vector<Clause>& body, const Head& head);
    void place_counts(Rule& rule) const;
    void add(Rule rule);
    // The rule with -o, without sigils that contradict a declaration.
    std::string consuming(const syntax::Rule& tree) const;
    void suggest_to_start_once(VariableId place, diagnostics::Diagnostic& d) const;
    // A linear fact for each new way to satisfy the body (resolve_once.cpp).
    void once(const Rule& rule, const std::vector<Clause>& body, const Head& head);
    // A comprehension or aggregate of a view that consumes linear facts does so once for each way; false: it asks for none.
    bool part_with_linear_facts(const Rule& rule, const std::vector<Clause>& body, const Head& head);
    void once(const Rule& rule, const std::vector<Clause>& body, const Head& head, const Term& goal, const std::string& name);
    // Whether a view holds at a node to which no link of its body leads, so that its facts are sent there.
    bool is_sent(const std::vector<Clause>& body, const Head& head) const;
    void sent_view(const Rule& rule, const std::vector<Clause>& body, const Head& head);
    void find_single_use(Rule& rule) const;
    void note_lower_case();

    const source::FileSet& files_;
    const Names& names_;
    Program& program_;
    diagnostics::Reporter& report_;
    std::set<std::uint32_t> linear_files_;
    LaterFixes later_;
    Scope* scope_ = nullptr;
    const LocalNames* locals_ = nullptr;
    Rule* rule_ = nullptr;
    const syntax::Rule* tree_ = nullptr;
    Variables hinted_;                        // Variables in hints that are left out.
    std::map<std::string, int> rules_named_;  // So far, by head and line.
    int rules_once_ = 0, rules_sent_ = 0;     // So far.
    std::map<std::string, Place> places_;     // Computed catoms of this rule, as written.
    std::vector<Place> fixed_;                // Fixed ones.
    std::vector<Clause> fixed_inside_;        // The tests of those that only a part of the rule names.
    bool dialect_linear_ = false;
    // Some head or fact of the program is a persistent `!p(...)`, which nobody writes for a negation.
    bool persistent_marked_ = false;
    diagnostics::Diagnostic* sign_note_ = nullptr;                // Once in a program.
    diagnostics::Diagnostic* consuming_note_ = nullptr;           // Once in a program.
    std::map<std::string, diagnostics::Diagnostic*> hint_notes_;  // Once in a program for each word.
    std::size_t errors_before_ = 0;
    // The rule uses a predicate whose declaration has an error.
    bool refused_ = false;
    bool lost_ = false;                                   // Some rule is not in the program because of an error.
    diagnostics::Diagnostic* lower_case_note_ = nullptr;  // Once in a program.
};

// Enters a part of a rule with local names, and leaves it again.
class Inside {
  public:
    Inside(Scope& scope, const LocalNames& locals, const void* part) : scope_(scope) { scope_.enter(part, locals.of(part)); }
    ~Inside() { scope_.leave(); }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;

  private:
    Scope& scope_;
};

}  // namespace meld::check
