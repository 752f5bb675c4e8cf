// The syntax tree: the result of the parser, with nothing resolved. It covers the union of the grammars of Meld's dialects.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "compiler/source/source.h"

namespace meld::syntax {

using source::Span;

struct Name {
    std::string text;
    Span span;
};

// ---- types: `int`, `list T`, `set T`, `array T`, `:(T, U)`, `(T, U)`, or a name declared with `type list int vector.`

struct Type {
    // "int", "list", "set", "array", "struct", "tuple", "vec3", or the name as written.
    std::string name;
    std::vector<Type> arguments = {};
    Span span = {};
};

// ---- expressions

struct Expr;
using ExprPtr = std::unique_ptr<Expr>;

struct IntLiteral {
    std::int64_t value;
};  // 12
struct FloatLiteral {
    double value;
};  // 0.5
struct BoolLiteral {
    bool value;
};  // true
struct StringLiteral {
    std::string value;
};  // "text", escapes already resolved
struct CatomLiteral {
    std::int64_t id;
};  // @7, #7
struct WorldSize {};  // @world
struct RunArgument {
    int number;
};  // @arg1
struct Variable {
    std::string name;
};  // X
struct Anonymous {};  // _
// f(X, Y); a bare lower-case name is a call without parentheses (a constant, or a variable in original Meld).
struct Call {
    std::string name;
    std::vector<ExprPtr> arguments;
    bool parentheses = true;
};
enum class UnaryOp { Negate, Not };  // -X  ~X
struct Unary {
    UnaryOp op;
    ExprPtr operand;
};
// The operators of operators.def.
enum class BinaryOp {
#define MELD_BINARY(name, spelling, level, groups) name,
#include "compiler/syntax/operators.def"
};
struct Binary {
    BinaryOp op;
    ExprPtr left, right;
};  // X + 1, A <> B, P && Q
// More operators of one level than make a tree (operators.h), in the order of the text: ops[i] stands between operands i and i + 1.
struct Chain {
    std::deque<ExprPtr> operands;
    std::deque<BinaryOp> ops;
};
struct Conditional {
    ExprPtr condition, then_value, else_value;
};  // if c then e else e end
struct Let {
    Name variable;
    ExprPtr value, body;
};  // let X = e in e end
struct ListValue {
    std::vector<ExprPtr> elements;
    ExprPtr rest;
};  // [1, 2 | Rest]; X::Rest is one element and a rest
struct StructValue {
    std::vector<ExprPtr> fields;
};  // :(1, 2.0)
struct TupleValue {
    std::vector<ExprPtr> fields;
};  // (1, 2)

struct Expr {
    std::variant<IntLiteral, FloatLiteral, BoolLiteral, StringLiteral, CatomLiteral, WorldSize, RunArgument, Variable, Anonymous, Call,
                 Unary, Binary, Chain, Conditional, Let, ListValue, StructValue, TupleValue>
        node;
    Span span;
};

// ---- bodies

enum class Sigil { None, Persistent, Linear, Read };  // p  !p  ?p  $p

struct Atom {  // !p(A, X + 1)
    Sigil sigil = Sigil::None;
    Name name;
    std::vector<ExprPtr> arguments;
    Span span;
};

struct Clause;
struct Constraint {
    ExprPtr condition;
};  // X > 1, X = e (binds where X is free)
struct Not {
    std::vector<Clause> clauses;
};  // not p(A, X); one atom, or clauses in parentheses
struct Forall {
    Atom atom;
    std::vector<Clause> clauses;
};  // forall p(A, B)[q(B)]
struct Element {
    ExprPtr element, list;
};  // E in List
struct Delta {
    Name variable;
    Atom atom;
    BinaryOp op;
    ExprPtr bound;
};  // delta(X; p(A, X)) > e
struct Proved {
    ExprPtr count;
    Name predicate;
    ExprPtr at;
};  // proved(N, p), or N = proved(A, p)
struct BodyAggregate {
    Name result;
    std::string op;
    ExprPtr parameter;
    ExprPtr value;
    std::vector<Clause> clauses;
};  // S = sum X : { p(A, X) }, L = min_k(3) X : { p(A, X) }

struct Clause {
    std::variant<Atom, Constraint, Not, Forall, Element, Delta, Proved, BodyAggregate> node;
    Span span;
};

// ---- heads

struct HeadItem;
struct Delay {
    double amount;
    enum class Unit { Seconds, Milliseconds, Ticks } unit;
    Span span;
};  // @+2s @+250ms @+3
struct HeadFact {
    Atom atom;
    std::optional<Delay> delay;
};  // p(A, X)@+1
struct Comprehension {
    std::vector<Name> variables;
    std::vector<Clause> body;
    std::vector<HeadItem> head;
};  // { X | b | h }
struct HeadAggregate {
    std::string op;
    std::string function;
    ExprPtr parameter;
    Name result;
};  // sum => S, custom f 0 => V, min_k(3) => L
// [ sum => S, count => C | X | body | head1 | head2 ]: head1 once per match, head2 once with the results.
struct RuleAggregate {
    std::vector<HeadAggregate> aggregates;
    std::vector<Name> variables;
    std::vector<Clause> body;
    std::vector<HeadItem> each, result;
};
struct Exists {
    std::vector<Name> variables;
    std::vector<HeadItem> head;
};  // exists X. ( ... )
struct HeadIf {
    ExprPtr condition;
    std::vector<HeadItem> then_head, else_head;
};  // (if c then h otherwise h end)
struct HeadLet {
    Name variable;
    ExprPtr value;
};  // X = e: in the heads behind it
struct Nothing {};  // 1

struct HeadItem {
    std::variant<HeadFact, Comprehension, RuleAggregate, Exists, HeadIf, HeadLet, Nothing> node;
    Span span;
};

enum class Arrow { View, Linear, Axiom, Question };  // :-   -o   a fact alone   a body alone, which nobody can write in a program

struct Selector {
    enum class Order { Ascending, Descending, Random, Minimum } order;
    Name variable;
};  // [desc => X | body]

struct Rule {
    Arrow arrow = Arrow::View;
    std::optional<Selector> selector;
    std::vector<Clause> body;
    std::vector<HeadItem> head;
    Span span;
};

// ---- declarations

struct Argument {
    Type type;
    std::optional<Name> name;
    // A word of aggregates.def, or a function's name; empty: none.
    std::string aggregate;
    Span aggregate_span = {};
    // The number in `min_k(3)`, or the name of a constant.
    std::optional<std::variant<std::int64_t, Name>> aggregate_parameter = {};
    bool neighbour_complete = false;  // [<- neighbor]
    // Where neighbour_complete: the link, and whether its catoms are those it points to, [-> edge].
    Name neighbour_link = {};
    bool neighbour_outgoing = false;
    Span span = {};
};

struct Declaration {              // type route p(node, min int D).
    std::vector<Name> modifiers;  // route linear action sensed persistent virtual ...
    Name name;
    std::vector<Argument> arguments;
    bool repeats = false;  // ... while.
    Span span;
};

struct Constant {
    Name name;
    ExprPtr value;
    Span span;
};  // const name = e.
struct Parameter {
    Type type;
    Name name;
};
struct Function {
    Name name;
    std::vector<Parameter> parameters;
    Type result;
    ExprPtr body;
    Span span;
};  // fun f(int X) : int = X + 1.
struct Extern {
    Name name;
    std::optional<Type> result;
    std::vector<Type> arguments;
    Span span;
};  // extern float f(int).  extern type h.
struct Alias {
    Type type;
    Name name;
    Span span;
};  // type list int vector.
struct NodeKind {
    Name name;
    Span span;
};  // node kind.
// import linear p(node, int) as q from file.  `unit` is what the file's names belong to (Tree::units), known once it is read.
struct Import {
    std::string path;
    Name predicate, as;
    std::optional<Declaration> declaration;
    Span span;
    Span path_span = {};
    std::uint32_t unit = kNoUnit;
    static constexpr std::uint32_t kNoUnit = 0xffffffff;
};
struct Export {
    Name predicate;
    Span span;
};
struct Module {
    Name name;
    Span span;
};
// priority, index, compact, data: accepted, remembered as written.
struct Hint {
    Name directive;
    std::string text;
    std::vector<Name> names;
    Span span;
};

using Item = std::variant<Declaration, Constant, Function, Extern, Alias, NodeKind, Import, Export, Module, Hint, Rule>;

// Whose names they are: the program's, or those of a module, a file that begins with `module name.` or that others import from.
struct Unit {
    std::string name;  // Empty: the program.
    Span span = {};    // Where it is named, or the beginning of its file.
    // An instance of a module: the name that the unit which uses it gives it, and that unit.
    std::string alias = {};
    std::uint32_t user = 0;
};

// A file with everything it includes and uses, in order. Items of included files stand where the include stood.
struct Tree {
    std::vector<Item> items;
    std::vector<std::uint32_t> unit_of;  // By item: an index into `units`.
    std::vector<Unit> units;
    // Names that stand in items with a syntax error: whether they are declared there cannot be known, so nobody should say
    // that they are not. Where a whole file is missing that holds for every name.
    std::set<std::string> lost = {};
    bool lost_file = false;
    // A library whose names all units see, as they see the prelude.
    std::optional<std::uint32_t> shared_file = {};
    // Every include and import, in the order of reading.
    struct Include {
        Span where;                         // The name.
        std::optional<std::uint32_t> file;  // None if it was not looked for, or not found.
    };
    std::vector<Include> includes = {};
    // By file: which programs it is part of, one bit each, the lowest for the first. Empty: there is one program.
    std::vector<std::uint64_t> programs_of = {};

    void add(Item item, std::uint32_t unit) {
        items.push_back(std::move(item));
        unit_of.push_back(unit);
    }
    // Adds the items and units of another tree; this one has no modules, only names that all the others share.
    void append(Tree other) {
        for (std::size_t i = 0; i < other.items.size(); ++i) add(std::move(other.items[i]), other.unit_of[i]);
        units = std::move(other.units);
        lost.merge(other.lost);
        lost_file = lost_file || other.lost_file;
        programs_of = std::move(other.programs_of);
        shared_file = other.shared_file;
    }
    bool is_lost(const std::string& name) const { return lost_file || lost.contains(name); }
};

}  // namespace meld::syntax
