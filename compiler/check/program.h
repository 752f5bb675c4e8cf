// The checked program: names resolved, types known, every rule with one home catom. What all later stages work on.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/source/source.h"
#include "runtime/base/ids.h"

namespace meld::check {

using source::Span;

// Error stands for "already reported": it fits everything, so one mistake gives one message.
enum class Type { Error, Int, Float, Bool, Node, String };
std::string type_name(Type type);

enum class PredicateKind { Persistent, Linear, Action, Sensed };
enum class Aggregate { None, Min, Max, Sum, Count, First };
std::string aggregate_name(Aggregate aggregate);

// Sensed predicates that are read from the ensemble and stored nowhere.
enum class WorldSource { None, Neighbor, NeighborPort, NeighborCount, Vacant, Cell, Position, Id, Tick, Target, TargetPort };

struct Argument {
    Type type = Type::Error;
    std::string name;
};

struct Predicate {
    std::string name;
    Span span;
    std::vector<Argument> arguments;  // The catom first.
    PredicateKind kind = PredicateKind::Persistent;
    bool sensed = false;              // Maintained by the runtime (also linear ones, as `tap`).
    bool route = false;               // The second argument is the catom it points to.
    bool repeats = false;             // type action ... while.
    bool prelude = false;             // Declared in stdlib/prelude.meld.
    bool auxiliary = false;           // Made by the planner.
    bool refused = false;             // Its declaration has been reported; rules that use it are not looked at further.
    Aggregate aggregate = Aggregate::None;
    std::size_t aggregate_at = 0;     // Index into arguments; those between 1 and it are the group, those after it ride along.
    WorldSource world = WorldSource::None;
    Id<Predicate> given;              // The auxiliary that stores facts given from outside, if not this one.

    bool linear() const { return kind == PredicateKind::Linear; }
    // name/arity, as messages say it.
    std::string signature() const { return name + "/" + std::to_string(arguments.size()); }
};
using PredicateId = Id<Predicate>;

struct Constant {
    std::string name;
    Span span;
    Type type = Type::Error;
    std::int64_t integer = 0;         // Int, Bool, Node
    double real = 0;                  // Float
    bool prelude = false;
};
using ConstantId = Id<Constant>;

struct Variable {
    std::string name;
    Span span;
    Type type = Type::Error;
};
using VariableId = Id<Variable>;

// An expression over variables. One shape for all operators keeps copying and rewriting short.
enum class Op {
    Variable, Anonymous, Int, Float, Bool, Node, Constant, String,
    Negate, Not, ToFloat,
    Add, Subtract, Multiply, Divide, Modulo, Power,
    Equal, NotEqual, Less, LessEqual, Greater, GreaterEqual, And, Or,
    If,
    Min, Max, Abs, Truncate, Sqrt, NodeToInt,  // Functions.
};

struct Term {
    Op op = Op::Anonymous;
    Type type = Type::Error;
    Span span;
    std::int64_t integer = 0;
    double real = 0;
    std::string text;
    VariableId variable;
    ConstantId constant;
    std::vector<Term> operands = {};

    bool is_variable() const { return op == Op::Variable; }
};

struct Atom {
    PredicateId predicate;
    std::vector<Term> arguments;      // The catom first; in bodies and heads a variable.
    bool read_only = false;           // $p: a linear fact that is read and left.
    Span span;
};

// Part of a body. `forall p[q]` has become Not{p, Not{q}}.
struct Clause {
    enum class Kind { Atom, Test, Not } kind = Kind::Atom;
    Atom atom = {};
    Term test = {};                   // Bool; an equality with one free variable binds it.
    std::vector<Clause> inner = {};   // Not: none of the ways to satisfy all of these exists.
    Span span = {};
};

struct Head {
    enum class Kind { Fact, Comprehension } kind = Kind::Fact;
    Atom atom = {};
    std::vector<Clause> body = {};    // Comprehension: for every way to satisfy it,
    std::vector<Head> heads = {};     // these.
    Span span = {};
};

struct Rule {
    std::string name;                 // "dist@12": the head and the line.
    std::string text;                 // As Meld, printed from the syntax tree.
    std::uint32_t line = 0;
    Span span;
    bool linear = false;              // Consumes facts; else a view with exactly one head.
    VariableId home;                  // The catom where it runs: the head's of a view, the consumed facts' of a linear rule.
    Table<Variable> variables;
    std::vector<Clause> body;
    std::vector<Head> heads;
    bool birth = false;               // Linear facts given once to every new catom (an axiom).
    bool refused = false;             // A mistake in it has been reported; later passes leave it alone.
    std::vector<VariableId> used_once;
};
using RuleId = Id<Rule>;

// A set of predicates that depend on each other, or one predicate alone; in the order of evaluation.
struct Component {
    std::vector<PredicateId> predicates;
    std::vector<RuleId> rules;        // View rules that derive them.
    bool recursive = false;
    bool local = false;               // Some rule reads the component at its own catom.
    bool links = false;               // Some rule reads the component at another catom.
    bool tree = false;                // Recursive through sum or count over links.
};

struct Program {
    std::string name;
    std::string source_text;
    Table<Predicate> predicates;
    Table<Constant> constants;
    Table<Rule> rules;
    std::vector<Component> components;
};

// Meld-like text of the checked program with types, homes and components. For `meldc --emit=program`.
std::string print(const Program& program);
std::string print(const Program& program, const Rule& rule, const Term& term);
std::string print(const Program& program, const Rule& rule, const Atom& atom);
std::string print(const Program& program, const Rule& rule, const Clause& clause);
std::string print(const Program& program, const Rule& rule);

// Calls visit(const Term&) on every subterm, itself first.
template <class Visit>
void each_subterm(const Term& term, const Visit& visit) {
    visit(term);
    for (const Term& operand : term.operands) each_subterm(operand, visit);
}
template <class Visit>
void each_variable(const Term& term, const Visit& visit) {
    each_subterm(term, [&](const Term& t) {
        if (t.is_variable()) visit(t.variable);
    });
}
// Every variable of a clause, those inside negations too.
template <class Visit>
void each_variable(const Clause& clause, const Visit& visit) {
    for (const Term& argument : clause.atom.arguments) each_variable(argument, visit);
    each_variable(clause.test, visit);
    for (const Clause& inner : clause.inner) each_variable(inner, visit);
}
// Every atom of a body: visit(atom, negated).
template <class Visit>
void each_atom(const std::vector<Clause>& body, const Visit& visit, bool negated = false) {
    for (const Clause& clause : body) {
        if (clause.kind == Clause::Kind::Atom) visit(clause.atom, negated);
        if (clause.kind == Clause::Kind::Not) each_atom(clause.inner, visit, true);
    }
}

}  // namespace meld::check
