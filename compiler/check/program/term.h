// Types and expressions of the checked program.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/source/source.h"
#include "runtime/base/id_set.h"
#include "runtime/base/ids.h"

namespace meld::check {

using source::Span;

// A type. Lists, sets and arrays have one part, structs and tuples one part per field. Type::Int and similar ones are the simple types.
struct Type {
    // Error stands for "already reported" or "not known yet": it fits everything, so one mistake gives one message.
    enum class Kind { Error, Int, Float, Bool, Node, String, List, Set, Array, Struct, Tuple, Vec3 };
    Kind kind = Kind::Error;
    std::vector<Type> parts = {};

    static const Type Error, Int, Float, Bool, Node, String, Vec3;
    static Type list_of(Type element) { return {Kind::List, {std::move(element)}}; }

    // Whether its values are more than one word: they live in lists (runtime/module/abi/module_abi.h).
    bool compound() const { return kind >= Kind::String; }
    // Whether it has an order and arithmetic of numbers.
    bool numeric() const { return kind == Kind::Int || kind == Kind::Float; }
    bool operator==(const Type&) const = default;
};
inline const Type Type::Error{Type::Kind::Error}, Type::Int{Type::Kind::Int}, Type::Float{Type::Kind::Float}, Type::Bool{Type::Kind::Bool},
    Type::Node{Type::Kind::Node}, Type::String{Type::Kind::String}, Type::Vec3{Type::Kind::Vec3};
// As a program writes it: `list int`, `:(int, float)`.
std::string type_name(const Type& type);

struct Function;
using FunctionId = Id<Function>;

struct Constant;
using ConstantId = Id<Constant>;
struct Variable;
using VariableId = Id<Variable>;
using Variables = IdSet<Variable>;

// An expression over variables. One shape for all operators keeps copying and rewriting short.
enum class Op {
    Variable,
    Anonymous,
    Int,
    Float,
    Bool,
    Node,
    Constant,
    String,
    WorldSize,  // @world
    List,
    Cons,
    Struct,
    Tuple,  // Operands: elements; head and tail; fields.
    ListHead,
    ListTail,
    IsEmpty,
    Item,     // The value that patterns take apart; Item: field number `integer`.
    Let,      // `variable` = operands[0] in operands[1]
    Call,     // `function` of the program.
    Library,  // The function `text` of runtime/module/kernel/library.h.
    Now,      // The tick. Made by delays, as are the next two.
    Ticks,    // How many ticks operands[0] seconds are, at least 1.
    Due,      // Bool: operands[0] is not after now; if it is, the catom is woken then.
    Fresh,    // A unique value, for `exists`.
    NewNode,  // The same for a node of a graph that facts are given to. Made by relays, as is the next one.
    NextHop,  // Node: where a fact for operands[0] goes next, or the execution site if there is no way.
    Negate,
    Not,
    ToFloat,
#define MELD_BINARY(name, spelling, level, groups) name,
#include "compiler/syntax/operators.def"
    If,
    Min,
    Max,
    Abs,
    Truncate,
    Sqrt,
    NodeToInt,  // Functions.
};

struct Term {
    Op op = Op::Anonymous;
    Type type = Type::Error;
    Span span = {};
    std::int64_t integer = 0;
    double real = 0;
    std::string text = {};
    VariableId variable = {};
    ConstantId constant = {};
    FunctionId function = {};
    std::vector<Term> operands = {};

    bool is_variable() const { return op == Op::Variable; }
};

// An equality that builds or takes apart a list, struct or tuple: variable = constructor of variables and known values.
struct TakeApart {
    const Term* value = nullptr;
    const Term* constructor = nullptr;
    explicit operator bool() const { return value != nullptr; }
};
TakeApart taken_apart(const Term& test);

// Calls visit(const Term&) on every subterm, itself first.
template <class Visit>
void each_subterm(const Term& term, const Visit& visit) {
    visit(term);
    for (const Term& operand : term.operands) each_subterm(operand, visit);
}
// Whether test(const Term&) holds for one of its subterms, or for all; itself first, and no further than it has to look.
template <class Test>
bool any_subterm(const Term& term, const Test& test) {
    return test(term) || std::any_of(term.operands.begin(), term.operands.end(), [&](const Term& t) { return any_subterm(t, test); });
}
template <class Test>
bool all_subterms(const Term& term, const Test& test) {
    return !any_subterm(term, [&](const Term& t) { return !test(t); });
}
template <class Visit>
void each_variable(const Term& term, const Visit& visit) {
    each_subterm(term, [&](const Term& t) {
        if (t.is_variable() || t.op == Op::Let) visit(t.variable);
    });
}
// Every use of a variable that is not bound by a `let` around it: visit(const Term&).
template <class Visit>
void each_free_use(const Term& term, const Visit& visit, std::vector<VariableId>& bound) {
    if (term.is_variable()) {
        for (const VariableId v : bound)
            if (v == term.variable) return;
        visit(term);
        return;
    }
    for (std::size_t i = 0; i < term.operands.size(); ++i) {
        const bool inside = term.op == Op::Let && i == 1;
        if (inside) bound.push_back(term.variable);
        each_free_use(term.operands[i], visit, bound);
        if (inside) bound.pop_back();
    }
}
template <class Visit>
void each_free_use(const Term& term, const Visit& visit) {
    std::vector<VariableId> bound;
    each_free_use(term, visit, bound);
}
// Whether test(VariableId) holds for every variable that is used and not bound inside.
template <class Test>
bool all_free(const Term& term, const Test& test) {
    bool all = true;
    each_free_use(term, [&](const Term& use) { all = all && test(use.variable); });
    return all;
}
// Puts the value in the place of a variable.
inline void substitute(Term& term, VariableId variable, const Term& value) {
    if (term.is_variable() && term.variable == variable)
        term = value;
    else
        for (Term& operand : term.operands) substitute(operand, variable, value);
}
// Calls change(VariableId&) on every variable.
template <class Change>
void rewrite_variables(Term& term, const Change& change) {
    change(term.variable);
    for (Term& operand : term.operands) rewrite_variables(operand, change);
}
}  // namespace meld::check
