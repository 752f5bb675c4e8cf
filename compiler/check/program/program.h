// The checked program: names resolved, types known, every rule with one execution site. All later stages work on it.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "compiler/check/program/term.h"
#include "compiler/source/source.h"
#include "compiler/syntax/aggregates.h"
#include "runtime/base/ids.h"
#include "runtime/module/abi/senses.h"

namespace meld::check {

// What worlds a program is for. In graphs, facts also reach nodes that are known only by their value. Undecided becomes Graphs if the
// program has such rules and, without a world, runs in a graph of its own (own_graph.h); otherwise Any.
enum class Worlds { Any, Graphs, Undecided };

enum class PredicateKind { Persistent, Linear, Action, Sensed };
using syntax::Aggregate;
using syntax::AggregateInfo;
std::string aggregate_name(Aggregate aggregate);

using meld::WorldSource;

// A fact of the program's text.
struct Fact {
    std::int64_t catom = 0;
    std::vector<Term> arguments;  // After the catom; literals.
    std::uint32_t line = 0;
};

struct Argument {
    Type type = Type::Error;
    std::string name;
    std::int64_t least = INT64_MIN, greatest = INT64_MAX;  // Bounds that the planner's pass `narrow` has proved for an int.
};

struct Predicate {
    std::string name;
    Span span;                        // Of the name in its declaration.
    Span declaration;                 // Without the full stop.
    std::vector<Argument> arguments;  // The catom first.
    PredicateKind kind = PredicateKind::Persistent;
    bool sensed = false;     // Maintained by the runtime (also linear ones, as `tap`).
    bool route = false;      // The second argument is the catom it points to.
    bool repeats = false;    // type action ... while.
    bool prelude = false;    // Declared in stdlib/prelude.meld.
    bool repeated = false;   // Also declared by the program.
    bool auxiliary = false;  // Made by the compiler.
    bool refused = false;    // An error in its declaration was reported; rules that use it are not examined further.
    bool in_rounds = false;  // Of a stratum that is recursive in rounds.
    Aggregate aggregate = Aggregate::None;
    std::size_t aggregate_at = 0;  // Index into arguments; those between 1 and it are the group, those after it the payload.
    FunctionId fold;               // Aggregate::Custom
    Term parameter = {};           // The number of values that min_k and max_k keep: an int that is a literal or a constant.
    // Min or Max: the rows of a group are the front of the argument `aggregate_at` (fronts.h). Made by the planner.
    Aggregate front = Aggregate::None;
    // `[<- neighbor]`: the aggregate holds if every catom that this link predicate joins to this one has contributed.
    Id<Predicate> complete_link;
    bool complete_outgoing = false;  // `[-> edge]`: the catoms the link points to, not those it comes from.
    WorldSource world = WorldSource::None;
    std::vector<Fact> facts = {};  // WorldSource::Facts: all of them, by catom. Made by the planner.
    Id<Predicate> returns;         // `undelivered-p`: the p whose facts come back here when they cannot be delivered.
    // For an auxiliary that forwards facts of a linear predicate: that predicate, the number of catoms on the remaining path, which come
    // before their target, and the number of our arguments after theirs.
    Id<Predicate> carries;
    std::size_t passes = 0, behind = 0;
    bool begins = false;         // It goes to a node that its rule makes: the only catom of the path.
    Id<Predicate> sends;         // For an auxiliary with facts of a view under way to a node that no link leads to: that view.
    bool finds_its_way = false;  // The links that it still goes are found while it is under way; the path is only the present catom.
    Id<Predicate> given;         // The auxiliary that stores facts given from outside, if not this one.
    // Declared by the program in the place of a sensed predicate of the prelude: where that is declared, and how a program would do so.
    struct Hidden {
        Span span;
        std::string declaration;
    };
    std::optional<Hidden> hides = {};

    bool linear() const { return kind == PredicateKind::Linear; }
    // Whether every derivation counts, so that recursion through it is correct only along a tree.
    bool needs_all() const { return combines(aggregate) || complete_link.valid(); }
    // name/arity, as in messages.
    std::string signature() const { return name + "/" + std::to_string(arguments.size()); }
};
using PredicateId = Id<Predicate>;

struct Variable {
    std::string name;
    Span span;
    Type type = Type::Error;
};

struct Constant {
    std::string name;
    Span span;
    Type type = Type::Error;
    std::int64_t integer = 0;  // Int, Bool, Node
    double real = 0;           // Float
    std::string text;          // String
    Term value = {};           // All others: a term of literals.
    bool prelude = false;
    bool argument = false;     // @arg1: the run gives it, or an error says that it is missing.
    FunctionId computed = {};  // If valid, only the run can compute the value: by this function without parameters.
};

// fun f(int X) : int = X + 1.  or  extern float f(int).
struct Function {
    std::string name;
    Span span;
    Table<Variable> variables;  // The parameters first, then those of `let`.
    std::size_t parameter_count = 0;
    Type result = Type::Error;
    Term body = {};
    bool external = false;    // A C function of this name, linked in.
    bool of_library = false;  // Made for a fold by a function of the library (library_fold.h).
    bool refused = false;
};

struct Atom {
    PredicateId predicate;
    std::vector<Term> arguments;  // The catom first; in bodies and heads a variable.
    bool read_only = false;       // $p: a linear fact that is read and not consumed.
    Span span;
};

// Part of a body. `forall p[q]` has become Not{p, Not{q}}, `proved(N, p)` a count.
struct Clause {
    enum class Kind {
        Atom,
        Test,       // Bool; an equality with one free variable binds it, one with a list or struct of free variables takes it apart.
        Not,        // `inner` cannot be satisfied in any way.
        Element,    // `variable` is an element of the list or set `test`, once for each.
        Aggregate,  // `variable` is the aggregate of `test` over all ways to satisfy `inner`; over none: 0, [] or no match (min, max).
        Delta,      // `variable`, an argument of `atom`, has changed in this tick by an amount for which this comparison with `test` holds.
    } kind = Kind::Atom;
    Atom atom = {};
    Term test = {};
    std::vector<Clause> inner = {};
    VariableId variable = {};
    VariableId position = {};  // Element: its index, from 0, if it is needed. Made by delays.
    Aggregate aggregate = Aggregate::None;
    FunctionId fold = {};  // Aggregate::Custom
    // min_k and max_k: how many values they keep. Custom: the initial value, Anonymous for the first match.
    Term parameter = {};
    Op compare = Op::Greater;  // Delta
    Span span = {};
};

// [ sum => S, custom f 0 => V | X | body | head1 | head2 ]: one of the aggregates.
struct HeadAggregate {
    Aggregate aggregate = Aggregate::None;
    FunctionId function = {};  // Custom
    Term parameter = {};       // As Clause::parameter.
    VariableId each = {};      // The value of one match, in the body; invalid for a count.
    VariableId result = {};    // In the last heads.
};

struct Head {
    enum class Kind {
        Fact,
        Comprehension,  // For every way to satisfy `body`, `heads`.
        Aggregate,      // The same, and then `others` once with the results of `aggregates` over all matches.
        If,             // `heads` where `term` is true, else `others`.
        Set,            // `variable` = `term` in `heads`.
    } kind = Kind::Fact;
    Atom atom = {};
    Term delay = {};  // Fact: how many ticks it waits (Int); Anonymous: it does not wait.
    std::vector<Clause> body = {};
    std::vector<Head> heads = {};
    std::vector<Head> others = {};
    std::vector<HeadAggregate> aggregates = {};
    Term term = {};
    VariableId variable = {};
    Span span = {};
};

// [desc => X | body] -o head: of all matches the one with the greatest X; Random: any, drawn from the seed.
enum class Select { None, Ascending, Descending, Random };

struct Rule {
    std::string name;  // "dist@12": the head and the line.
    std::string text;  // As Meld, printed from the syntax tree.
    std::string file;  // Its name without folders.
    std::uint32_t line = 0;
    Span span;
    std::vector<PredicateId> derives;  // The predicates of its heads, as in the program; the planner may pass them through others.
    bool linear = false;               // Consumes facts; otherwise a view with exactly one head.
    VariableId site;  // The catom where it runs, its execution site: the head's of a view, the consumed facts' of a linear rule.
    Table<Variable> variables;
    std::vector<Clause> body;
    std::vector<Head> heads;
    bool arrives = false;       // Made by the planner: passes on facts that waited or came from further away, before all other rules.
    bool initial_fact = false;  // Linear facts given once to every new catom (an axiom).
    Select select = Select::None;
    VariableId selected;
    // For a view that waits for neighbours: those whose contributions its facts are.
    std::vector<VariableId> contributors;
    bool refused = false;  // A mistake in it has been reported; later passes leave it alone.
    std::vector<VariableId> used_once;
    // The body in the program's text, if this is one of several rules that stand for one of the text.
    std::vector<Clause> stands_for;
};
using RuleId = Id<Rule>;

// Predicates that are evaluated together: a strongly connected component (SCC) of those that depend on each other, a single predicate, or,
// once the planner has split trees, a part of an SCC.
struct Stratum {
    std::vector<PredicateId> predicates;
    std::vector<RuleId> rules;  // View rules that derive them.
    bool recursive = false;
    bool local = false;         // Some rule reads the stratum at its own catom.
    bool links = false;         // Some rule reads the stratum at another catom.
    bool tree = false;          // Recursive over links through an aggregate that needs_all(), or in rounds.
    bool rounds = false;        // Facts negate or aggregate each other, and rounds separate them (rounds.h).
    bool feeds_itself = false;  // The same at one catom: reported as an error.

    bool contains(PredicateId p) const { return std::binary_search(predicates.begin(), predicates.end(), p); }
};

struct Program {
    std::string name;
    // The files that it was read from, the program's own first, then those of other programs that some of the catoms run: where each is,
    // from the folder of that one, and its text. Not those that are part of the compiler.
    struct Source {
        std::string path, text;
    };
    std::vector<Source> sources;
    // How many of them are programs of the same ensemble, which come first: each catom runs the rules of one of them.
    std::uint32_t programs = 1;
    // Which of them each include and import means, in the order of reading; none: a library of the compiler.
    std::vector<std::optional<std::uint32_t>> includes;
    Table<Predicate> predicates;
    Table<Constant> constants;
    Table<Function> functions;
    Table<Rule> rules;
    // Bodies that somebody asks about a run: they run nowhere, have no heads, and may join any catoms and read any facts.
    std::vector<Rule> questions;
    std::vector<Stratum> strata;  // In the order of evaluation.
    Worlds worlds = Worlds::Any;
    bool own_graph = false;  // runs_in_own_graph()
    bool kinds = false;      // It declares kinds of nodes.
    // C files are linked: an extern is defined there, also where the library has a function of its name.
    bool links_c = false;
    // It is compiled in the links form: neighbours are found in a table, and there may be any number of them
    // (runtime/module/abi/geometry_abi.h).
    bool by_links = false;
    // The least priority goes first: the rules' priorities have been negated.
    bool priorities_upwards = false;
};

// The word for the aggregate of a predicate; for a function of the program its name.
std::string aggregate_name(const Program& program, const Predicate& p);
// Meld-like text of the checked program with types, execution sites and strata. For `meldc --emit=program`.
std::string print(const Program& program);
std::string print(const Program& program, const Rule& rule, const Term& term);
std::string print(const Program& program, const Rule& rule, const Atom& atom);
std::string print(const Program& program, const Rule& rule, const Clause& clause);
std::string print(const Program& program, const Rule& rule);

// ---- walks over bodies and heads. What a clause or a head consists of is said once, in each_part(); all others follow from it.

template <class T, class Of>
concept MaybeConst = std::same_as<std::remove_const_t<T>, Of>;

// The terms and variables of a clause itself, without those of the clauses inside: on_term(Term&), on_variable(VariableId&).
template <MaybeConst<Clause> AnyClause, class OnTerm, class OnVariable>
void each_part(AnyClause& clause, const OnTerm& on_term, const OnVariable& on_variable) {
    for (auto& argument : clause.atom.arguments) on_term(argument);
    on_term(clause.test);
    on_term(clause.parameter);
    on_variable(clause.variable);
    on_variable(clause.position);
}
// Those of a head itself, without its body and the heads inside.
template <MaybeConst<Head> AnyHead, class OnTerm, class OnVariable>
void each_part(AnyHead& head, const OnTerm& on_term, const OnVariable& on_variable) {
    for (auto& argument : head.atom.arguments) on_term(argument);
    on_term(head.delay);
    on_term(head.term);
    on_variable(head.variable);
    for (auto& one : head.aggregates) {
        on_term(one.parameter);
        on_variable(one.each);
        on_variable(one.result);
    }
}

// Every clause of a body, those inside negations and aggregates too: visit(Clause&).
template <class Body, class Visit>
void each_clause(Body& body, const Visit& visit) {
    for (auto& clause : body) {
        visit(clause);
        each_clause(clause.inner, visit);
    }
}
// Every head, those inside others too: visit(Head&).
template <class Heads, class Visit>
void each_head(Heads& heads, const Visit& visit) {
    for (auto& head : heads) {
        visit(head);
        each_head(head.heads, visit);
        each_head(head.others, visit);
    }
}
// Every atom of a body: visit(atom, negated). Atoms read by an aggregate or a delta count as negated: more facts there may mean fewer here.
template <class Visit>
void each_atom(const std::vector<Clause>& body, const Visit& visit, bool negated = false) {
    for (const Clause& clause : body) {
        if (clause.kind == Clause::Kind::Atom) visit(clause.atom, negated);
        if (clause.kind == Clause::Kind::Delta) visit(clause.atom, true);
        each_atom(clause.inner, visit, true);
    }
}

// The terms and variables of a clause or a head with all that is inside.
template <MaybeConst<Clause> AnyClause, class OnTerm, class OnVariable>
void each_part_inside(AnyClause& clause, const OnTerm& on_term, const OnVariable& on_variable) {
    each_part(clause, on_term, on_variable);
    for (auto& inner : clause.inner) each_part_inside(inner, on_term, on_variable);
}
template <MaybeConst<Head> AnyHead, class OnTerm, class OnVariable>
void each_part_inside(AnyHead& head, const OnTerm& on_term, const OnVariable& on_variable) {
    each_part(head, on_term, on_variable);
    for (auto& clause : head.body) each_part_inside(clause, on_term, on_variable);
    for (auto& inner : head.heads) each_part_inside(inner, on_term, on_variable);
    for (auto& inner : head.others) each_part_inside(inner, on_term, on_variable);
}

template <class T>
concept ClauseOrHead = MaybeConst<T, Clause> || MaybeConst<T, Head>;

// Every term of a clause or a head, of a body or heads, or of a rule, whole: not its subterms. visit(Term&).
template <ClauseOrHead Part, class Visit>
void each_term(Part& part, const Visit& visit) {
    each_part_inside(part, visit, [](const VariableId&) {});
}
template <ClauseOrHead Part, class Visit>
void each_term(const std::vector<Part>& parts, const Visit& visit) {
    for (const Part& part : parts) each_term(part, visit);
}
template <class Visit>
void each_term(const Rule& rule, const Visit& visit) {
    each_term(rule.body, visit);
    each_term(rule.heads, visit);
}
// Every variable that a clause or a head mentions anywhere: visit(VariableId).
template <ClauseOrHead Part, class Visit>
void each_variable(const Part& part, const Visit& visit) {
    each_part_inside(
        part, [&](const Term& t) { each_variable(t, visit); },
        [&](VariableId v) {
            if (v.valid()) visit(v);
        });
}
// Calls change(VariableId&) on every variable.
template <ClauseOrHead Part, class Change>
void rewrite_variables(Part& part, const Change& change) {
    each_part_inside(part, [&](Term& t) { rewrite_variables(t, change); }, change);
}

}  // namespace meld::check
