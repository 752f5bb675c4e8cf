// Every construct of the language with values of every type. Each pair is refused by the compiler, or compiled into a module and run beside
// the reference evaluator; nothing else may happen. A type or a construct more is a row more in one of the tables.
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "compiler/check/program/library.h"
#include "compiler/check/program/types.h"
#include "compiler/syntax/aggregates.h"
#include "tests/reference/trials/run.h"

namespace meld::reference {
namespace {

using check::Type;

// A type, two of its values, and an expression of it with A, a catom, and I, its number.
struct TypeRow {
    std::string name, first, second, made;
};
const std::vector<TypeRow> kTypes = {
    {"int", "7", "-3", "I"},
    {"float", "2.5", "-0.5", "float(I) / 2"},
    {"bool", "true", "false", "if I = 1 then true else false end"},
    {"node", "@1", "@0", "A"},
    {"string", "\"b\"", "\"\"", "int2str(I)"},
    {"vec3", "vec3(1, 2, 3)", "vec3(0, 0, 0)", "vec3(float(I), 0.5, -1)"},
    {"list int", "[3, 1]", "[]", "[I, 2]"},
    {"list float", "[0.5]", "[]", "[float(I), 1.5]"},
    {"list bool", "[true]", "[]", "[false, true]"},
    {"list node", "[@1]", "[]", "[A]"},
    {"list string", "[\"a\"]", "[]", "[int2str(I)]"},
    {"list vec3", "[vec3(0, 1, 0)]", "[]", "[vec3(float(I), 0, 0)]"},
    {"list list int", "[[1], []]", "[]", "[[I], [2, I]]"},
    {"list (int, string)", "[(1, \"a\")]", "[]", "[(I, \"b\")]"},
    {"set int", "list2set([2, 1])", "list2set([])", "list2set([I, 1])"},
    {"set string", "list2set([\"b\", \"a\"])", "list2set([])", "list2set([int2str(I)])"},
    {"array int", "list2array([1, 2])", "list2array([])", "list2array([I])"},
    {":(int, string)", ":(1, \"a\")", ":(0, \"\")", ":(I, \"i\")"},
    {"(float, node)", "(0.5, @1)", "(1.5, @0)", "(float(I), A)"},
    {"(int, list vec3)", "(1, [vec3(1, 0, 0)])", "(0, [])", "(I, [vec3(0, 0, 1)])"},
    {":(vec3, set int)", ":(vec3(1, 0, 0), list2set([1]))", ":(vec3(0, 0, 0), list2set([2, 1]))", ":(vec3(0, float(I), 0), list2set([I]))"},
};

// Which types a construct takes.
using Takes = bool (*)(const Type&);
bool any(const Type&) { return true; }
bool number(const Type& t) { return t.numeric(); }
bool real(const Type& t) { return t == Type::Float; }
bool truth(const Type& t) { return t == Type::Bool; }
bool fresh(const Type& t) { return t == Type::Int || t == Type::Node; }
bool vector_or_number(const Type& t) { return t.numeric() || t == Type::Vec3; }
bool a_set(const Type& t) { return t.kind == Type::Kind::Set; }
bool list_or_text(const Type& t) { return t.kind == Type::Kind::List || t == Type::String; }
bool joins(const Type& t) { return list_or_text(t) || t.kind == Type::Kind::Array; }
bool elements(const Type& t) { return t.kind == Type::Kind::List || t.kind == Type::Kind::Set || t.kind == Type::Kind::Array; }

// {v}: facts of this type, here and at neighbours; {w}: linear ones; {go}: a linear fact of each catom. {T}, {1}, {2} and {made}: the
// columns of the type. {r}: a name of its own.
struct Construct {
    std::string name, text;
    Takes takes = any;
};
const std::vector<Construct> kConstructs = {
    // Facts, links, recursion
    {"facts of the text", "type {r}(node, {T}).\n{r}(@0, {1}).\n{r}(A, {2}).\n"},
    {"linear facts of the text", "type linear {r}(node, {T}).\n{r}(@0, {1}).\n{r}(A, {2}).\n"},
    {"two arguments", "type {r}(node, {T}, {T}).\n{r}(A, X, Y) :- {v}(A, X), {v}(A, Y).\n"},
    {"over a link", "type {r}(node, {T}).\n{r}(B, X) :- neighbor(A, B), {v}(A, X).\n"},
    {"over two links", "type {r}(node, {T}).\n{r}(C, X) :- neighbor(A, B), neighbor(B, C), {v}(A, X).\n"},
    {"a join", "type {r}(node, {T}).\n{r}(A, X) :- neighbor(A, B), {v}(A, X), {v}(B, X).\n"},
    {"recursion", "type {r}(node, {T}).\n{r}(A, X) :- {v}(A, X).\n{r}(B, X) :- neighbor(A, B), {r}(A, X).\n"},
    {"a route with it",
     "type route {r}(node, node, {T}).\ntype {r}s(node, {T}).\n{r}(A, B, X) :- neighbor(A, B), {v}(A, X).\n"
     "{r}s(B, X) :- {r}(A, B, X).\n"},
    {"a delay", "type {r}(node, {T}).\n{r}(A, X)@+2 :- {v}(A, X).\n"},
    {"negation", "type {r}(node, {T}).\n{r}(A, X) :- {v}(A, X), not (neighbor(A, B), {v}(B, X)).\n"},
    {"negation of a value", "type {r}(node).\n{r}(A) :- id(A, _), not {v}(A, {1}).\n"},
    {"forall", "type {r}(node).\n{r}(A) :- id(A, _), forall {v}(A, X) [ X <> {2} ].\n"},
    {"proved", "type {r}(node, int).\n{r}(A, N) :- id(A, _), proved(N, {v}).\n"},
    {"an action", "type action {r}(node, {T}).\n{r}(A, X) :- {v}(A, X).\n"},
    {"a stable fact", "type {r}(node, {T}).\n{go}(A), stable({v}(A, X), 3) -o {r}(A, X).\n"},
    // Expressions
    {"made", "type {r}(node, {T}).\n{r}(A, {made}) :- id(A, I).\n"},
    {"a constant", "const {r}c = {1}.\ntype {r}(node, {T}).\n{r}(A, {r}c).\n"},
    {"a function", "fun {r}f({T} X) : {T} = X.\ntype {r}(node, {T}).\n{r}(A, {r}f(X)) :- {v}(A, X).\n"},
    {"if", "type {r}(node, {T}).\n{r}(A, if I = 1 then X else {2} end) :- {v}(A, X), id(A, I).\n"},
    {"let", "type {r}(node, {T}).\n{r}(A, let Y = X in Y end) :- {v}(A, X).\n"},
    {"an equation", "type {r}(node, {T}).\n{r}(A, Y) :- {v}(A, X), Y = X.\n"},
    {"a list of it", "type {r}(node, list {T}).\n{r}(A, [X, {1}]) :- {v}(A, X).\n"},
    {"a list before a list", "type {r}(node, list {T}).\n{r}(A, [X | [{1}]]) :- {v}(A, X).\n"},
    {"a set of it", "type {r}(node, set {T}).\n{r}(A, [X, {1}]) :- {v}(A, X).\n"},
    {"a tuple with it", "type {r}(node, (int, {T})).\n{r}(A, (I, X)) :- {v}(A, X), id(A, I).\n"},
    {"a struct taken apart",
     "type {r}s(node, :({T}, int)).\ntype {r}(node, {T}).\n{r}s(A, :(X, 1)) :- {v}(A, X).\n"
     "{r}(A, X) :- {r}s(A, :(X, _)).\n"},
    {"a list taken apart",
     "type {r}s(node, list {T}).\ntype {r}(node, {T}, int).\n{r}s(A, [X, {2}]) :- {v}(A, X).\n"
     "{r}(A, X, llength(R)) :- {r}s(A, [X | R]).\n"},
    {"an element", "type {r}(node, {T}).\n{r}(A, X) :- {v}(A, Y), X in [Y, {1}].\n"},
    {"no element", "type {r}(node, {T}).\n{r}(A, X) :- {v}(A, X), ~ X in [{1}].\n"},
    {"elements of it", "type {r}(node).\n{r}(A) :- {v}(A, X), _ in X.\n", elements},
    {"=", "type {r}(node).\n{r}(A) :- {v}(A, X), X = {1}.\n"},
    {"<>", "type {r}(node, {T}).\n{r}(A, X) :- {v}(A, X), X <> {1}.\n"},
    {"<", "type {r}(node, {T}).\n{r}(A, X) :- {v}(A, X), {v}(A, Y), X < Y.\n", check::ordered},
    {">=", "type {r}(node, {T}).\n{r}(A, X) :- {v}(A, X), X >= {1}.\n", check::ordered},
    {"a comparison as a value", "type {r}(node, bool).\n{r}(A, X = {1}) :- {v}(A, X).\n"},
    {"+", "type {r}(node, {T}).\n{r}(A, X + {1}) :- {v}(A, X).\n", vector_or_number},
    {"-", "type {r}(node, {T}).\n{r}(A, X - {1}) :- {v}(A, X).\n", vector_or_number},
    {"*", "type {r}(node, {T}).\n{r}(A, X * {1}) :- {v}(A, X).\n", number},
    {"* number", "type {r}(node, {T}).\n{r}(A, X * 2) :- {v}(A, X).\n", vector_or_number},
    {"/", "type {r}(node, {T}).\n{r}(A, X / {1}) :- {v}(A, X).\n", number},
    {"/ number", "type {r}(node, {T}).\n{r}(A, X / 2) :- {v}(A, X).\n", vector_or_number},
    {"%", "type {r}(node, {T}).\n{r}(A, X % {1}) :- {v}(A, X).\n", number},
    {"^", "type {r}(node, {T}).\n{r}(A, X ^ 2) :- {v}(A, X).\n", number},
    {"unary -", "type {r}(node, {T}).\n{r}(A, -X) :- {v}(A, X).\n", vector_or_number},
    {"~", "type {r}(node, {T}).\n{r}(A, ~X) :- {v}(A, X).\n", truth},
    {"&&", "type {r}(node, {T}).\n{r}(A, X && {1} || {2}) :- {v}(A, X).\n", truth},
    {"++", "type {r}(node, {T}).\n{r}(A, X ++ {1}) :- {v}(A, X).\n", joins},
    {"min and max", "type {r}(node, {T}, {T}).\n{r}(A, min(X, {1}), max(X, {1})) :- {v}(A, X).\n", number},
    {"abs", "type {r}(node, {T}).\n{r}(A, abs(X)) :- {v}(A, X).\n", number},
    {"delta", "type {r}(node, {T}).\n{go}(A), delta(X; {v}(A, X)) > 0 -o {r}(A, X).\n", number},
    // Declared aggregates
    {"declared payload", "type {r}(node, min int, {T}).\n{r}(A, 1, X) :- {v}(A, X).\n"},
    {"declared group", "type {r}(node, {T}, count int).\n{r}(A, X, 1) :- neighbor(A, B), {v}(B, X).\n"},
    {"declared count", "type {r}(node, count int).\n{r}(A, X) :- {v}(A, X).\n"},
    {"declared first", "type {r}(node, first {T}).\n{r}(A, {1}) :- id(A, _).\n"},
    {"declared fold", "fun {r}f({T} X, {T} Y) : {T} = if X = {2} then Y else X end.\ntype {r}(node, {r}f {T}).\n{r}(A, X) :- {v}(A, X).\n"},
    {"min over links", "type {r}(node, min {T}).\n{r}(A, X) :- {v}(A, X).\n{r}(B, X) :- neighbor(A, B), {r}(A, X).\n"},
    {"max that waits", "type {r}(node, max {T} [<- neighbor]).\n{r}(A, X) :- {v}(A, X).\n{r}(A, X) :- neighbor(A, B), {v}(B, X).\n"},
    // Linear rules
    {"a linear rule", "type {r}(node, {T}).\n{w}(A, X) -o {r}(A, X).\n"},
    {"a pair of linear facts", "type {r}(node, {T}, {T}).\n{w}(A, X), {w}(A, Y) -o {r}(A, X, Y).\n"},
    {"a linear value", "type {r}(node).\n{w}(A, {1}) -o {r}(A).\n"},
    {"a message",
     "type linear {r}m(node, {T}).\ntype {r}(node, {T}).\n{w}(A, X), neighbor(A, B) -o {r}m(B, X).\n{r}m(A, X) -o {r}(A, X).\n"},
    {"a late message", "type linear {r}m(node, {T}).\ntype {r}(node, {T}).\n{w}(A, X) -o {r}m(A, X)@+2.\n{r}m(A, X) -o {r}(A, X).\n"},
    {"a comprehension", "type {r}(node, {T}).\n{go}(A) -o { X | {v}(A, X) | {r}(A, X) }.\n"},
    {"a comprehension that consumes", "type {r}(node, {T}).\n{go}(A) -o { X | {w}(A, X) | {r}(A, X) }.\n"},
    {"letters",
     "type linear {r}m(node, {T}).\ntype {r}(node, {T}).\n{w}(A, X) -o { B | neighbor(A, B) | {r}m(B, X) }.\n"
     "{r}m(A, X) -o {r}(A, X).\n"},
    {"if in a head", "type {r}(node, {T}).\n{w}(A, X) -o (if X = {1} then {r}(A, X) otherwise {r}(A, {2}) end).\n"},
    {"= in a head", "type {r}(node, {T}).\n{w}(A, X) -o Y = X, {r}(A, Y).\n"},
    {"exists", "type {r}(node, {T}).\n{go}(A) -o exists X. ({r}(A, X)).\n", fresh},
    {"absence", "type {r}(node).\n{go}(A), not {w}(A, {1}) -o {r}(A).\n"},
    {"once for each way", "type linear {r}m(node, {T}).\ntype {r}(node, {T}).\n{r}m(A, X) :- {v}(A, X).\n{r}m(A, X) -o {r}(A, X).\n"},
    {"a sum in one pass",
     "type linear {r}t(node, list {T}).\ntype {r}(node, list {T}).\n{r}t(A, []).\n"
     "{r}t(A, L), {w}(A, X) -o {r}t(A, L ++ [X]).\n{r}t(A, L), {go}(A) -o {r}(A, L).\n"},
    {"asc", "type {r}(node, {T}).\ntype {r}n(node).\n[asc => X | {w}(A, X), {go}(A)] -o {r}(A, X).\n"},
    {"desc", "type {r}(node, {T}).\n[desc => X | {w}(A, X), {go}(A)] -o {r}(A, X).\n"},
    {"random", "type {r}(node, {T}).\n[random => X | {w}(A, X), {go}(A)] -o {r}(A, X).\n"},
    {"custom from a value",
     "fun {r}f({T} X, {T} Y) : {T} = if X = {2} then Y else X end.\ntype {r}(node, {T}).\n"
     "{go}(A) -o [custom {r}f {2} => S | | {v}(A, S) | {r}(A, S)].\n"},
    {"custom",
     "fun {r}f({T} X, {T} Y) : {T} = if X = {2} then Y else X end.\ntype {r}(node, {T}).\n"
     "{go}(A) -o [custom {r}f => S | | {w}(A, S) | {r}(A, S)].\n"},
    {"each match", "type {r}(node, {T}).\ntype {r}n(node, int).\n{go}(A) -o [count => N | X | {w}(A, X) | {r}(A, X) | {r}n(A, N)].\n"},
    {"fold in a body",
     "fun {r}f({T} X, {T} Y) : {T} = if X = {2} then Y else X end.\ntype {r}(node, {T}).\n"
     "{r}(A, S) :- id(A, _), S = {r}f X : { {v}(A, X) }.\n"},
};

// What the aggregates of aggregates.def take.
Takes takes(const syntax::AggregateInfo& a, bool declared) {
    using Values = syntax::AggregateInfo::Values;
    switch (a.values) {
        case Values::Summable:
            return check::summable;
        case Values::Sets:
            return a_set;
        case Values::Lists:
            return list_or_text;
        case Values::Reals:
            return declared ? real : number;
        case Values::Bools:
            return truth;
        default:
            return any;
    }
}

std::string typed(const syntax::AggregateInfo& a, const std::string& type) {
    using Result = syntax::AggregateInfo::Result;
    return a.result == Result::ListOf ? "list " + type : a.result == Result::Int ? "int" : a.result == Result::Float ? "float" : type;
}

// Each aggregate in a declaration, in bodies, over nothing, as a condition, and in rule aggregates.
std::vector<Construct> constructs_of_aggregates(const std::string& type) {
    std::vector<Construct> out;
    for (const std::string& word : syntax::words_of_declared_aggregates()) {
        const syntax::AggregateInfo& a = syntax::info(syntax::declared_aggregate(word));
        if (a.values == syntax::AggregateInfo::Values::Counted) continue;
        const bool sized = a.has(syntax::AggregateInfo::kParameter);
        out.push_back({"declared " + word,
                       "type {r}(node, " + word + (sized ? "(2) list {T}" : " {T}") +
                           ").\n{r}(A, X) :- {v}(A, X).\n{r}(A, X) :- neighbor(A, B), {v}(B, X).\n",
                       takes(a, true)});
    }
    for (const std::string& word : syntax::words_of_aggregates_of_matches()) {
        const syntax::AggregateInfo& a = syntax::info(syntax::aggregate_of_matches(word));
        const bool counts = a.values == syntax::AggregateInfo::Values::Counted;
        const std::string op = word + (a.has(syntax::AggregateInfo::kParameter) ? "(2)" : ""), over = op + (counts ? "" : " X");
        const std::string declared = "type {r}(node, " + typed(a, type) + ").\n";
        const Takes which = takes(a, false);
        out.push_back({word + " in a body", declared + "{r}(A, S) :- id(A, _), S = " + over + " : { {v}(A, X) }.\n", which});
        // In which order neighbours come, the lattice decides, which the reference does not know.
        const std::string links = word == "collect" || word == "append" ? "neighbor(A, B), B = @1" : "neighbor(A, B)";
        out.push_back(
            {word + " over links", declared + "{r}(A, S) :- id(A, _), S = " + over + " : { " + links + ", {v}(B, X) }.\n", which});
        out.push_back(
            {word + " over nothing", declared + "{r}(A, S) :- id(A, _), S = " + over + " : { {v}(A, X), X = {1}, id(A, 9) }.\n", which});
        out.push_back({word + " as a condition",
                       declared + "{r}s(A, S) :- id(A, _), S = " + over + " : { {v}(A, X) }.\ntype {r}s(node, " + typed(a, type) +
                           ").\n{r}(A, S) :- {r}s(A, S), S = " + over + " : { {v}(A, X) }.\n",
                       which});
        const std::string value = counts ? "X" : "S";
        out.push_back({word + " in a head", declared + "{go}(A) -o [" + op + " => S | | {v}(A, " + value + ") | {r}(A, S)].\n", which});
        out.push_back({word + " that consumes", declared + "{go}(A) -o [" + op + " => S | | {w}(A, " + value + ") | {r}(A, S)].\n", which});
    }
    return out;
}

// Every function of the library with a parameter of any type, or of this one. `number`: an index or the like.
std::vector<Construct> constructs_of_library() {
    std::vector<Construct> out;
    for (const check::LibraryFunction& f : check::library()) {
        std::string arguments;
        bool generic = !f.random && f.section.size() > 0 && f.op == check::Op::Library, takes_any = false;
        for (const check::LibraryType& p : f.parameters) {
            std::string argument;
            if (p.variable == 'T') {
                argument = "{1}";
                takes_any = true;
            } else if (p.variable == 0 && p.parts.size() == 1 && p.parts[0].variable == 'T') {
                argument = p.kind == Type::Kind::List    ? "[X, {1}, X]"
                           : p.kind == Type::Kind::Set   ? "list2set([X, {1}])"
                           : p.kind == Type::Kind::Array ? "list2array([X, {1}])"
                                                         : "";
                takes_any = true;
            } else if (p.variable == 0 && p.kind == Type::Kind::Int) {
                argument = "1";
            }
            generic = generic && !argument.empty();
            arguments += (arguments.empty() ? "" : ", ") + argument;
        }
        if (!generic || !takes_any) continue;
        out.push_back({f.name, "type {r}(node, bool).\n{r}(A, " + f.name + "(" + arguments + ") = " + f.name + "(" + arguments +
                                   ")) :- {v}(A, X).\n"});
    }
    return out;
}

std::string filled(std::string text, const std::vector<std::pair<std::string, std::string>>& words) {
    for (const auto& [word, with] : words)
        for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; at += with.size()) text.replace(at, word.size(), with);
    return text;
}

std::string base_of(const TypeRow& row) {
    return filled(
        "type v(node, {T}).\nv(A, {made}) :- id(A, I).\nv(A, {1}) :- id(A, 0).\nv(A, {2}) :- id(A, 1).\nv(@2, {1}).\nv(@2, {2}).\n",
        {{"{T}", row.name}, {"{1}", row.first}, {"{2}", row.second}, {"{made}", row.made}});
}

std::string text_of(const Construct& c, const TypeRow& row, std::size_t number) {
    const std::string r = "r" + std::to_string(number), w = "w" + std::to_string(number), go = "go" + std::to_string(number);
    std::string text = c.text;
    if (text.find("{w}") != std::string::npos) text = "type linear {w}(node, {T}).\n{w}(A, {1}). {w}(A, {2}). {w}(@1, {1}).\n" + text;
    if (text.find("{go}") != std::string::npos) text = "type linear {go}(node).\n{go}(A).\n" + text;
    return filled(text, {{"{v}", "v"},
                         {"{w}", w},
                         {"{go}", go},
                         {"{r}", r},
                         {"{T}", row.name},
                         {"{1}", row.first},
                         {"{2}", row.second},
                         {"{made}", row.made}});
}

// A line of catoms, in which all comes to rest.
Trial trial_of(const std::string& text) {
    retraction::Case world{.seed = 1, .cells = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, .bursts = {{}}};
    return {{.declarations = {}, .rules = {}, .text = text, .given = {}}, std::move(world)};
}

class EveryType : public testing::TestWithParam<std::size_t> {};

TEST_P(EveryType, IsRefusedOrRuns) {
    const TypeRow& row = kTypes[GetParam()];
    const std::string base = base_of(row);
    const Result<check::Program> plain = checked(base);
    ASSERT_TRUE(plain) << plain.error().message();
    Type type;
    for (const check::Predicate& p : plain->predicates)
        if (p.name == "v") type = p.arguments[1].type;
    std::vector<Construct> all = kConstructs;
    for (const auto& more : {constructs_of_aggregates(row.name), constructs_of_library()}) all.insert(all.end(), more.begin(), more.end());
    std::string program = base;
    std::size_t compiled = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const std::string text = text_of(all[i], row, i);
        const Result<check::Program> alone = checked(base + text);
        EXPECT_EQ(alone.has_value(), all[i].takes(type)) << all[i].name << " of " << row.name << "\n"
                                                         << text << (alone ? "" : alone.error().message());
        if (!alone) continue;
        program += text;
        ++compiled;
    }
    EXPECT_GT(compiled, 60u);
    Workshop workshop(Level::Quick);
    const Result<Module> module = workshop.module(program);
    ASSERT_TRUE(module) << module.error().message();
    const Result<check::Program> whole = checked(program);
    ASSERT_TRUE(whole) << whole.error().message();
    const Outcome outcome = run(trial_of(program), *whole, info_of(*module), {}, Watch::Reference);
    EXPECT_EQ(outcome.trouble, "") << program;
    EXPECT_GT(outcome.tally.facts, compiled);
}

std::string name_of(const testing::TestParamInfo<std::size_t>& info) {
    std::string name;
    for (const char c : kTypes[info.param].name) name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
    return name + "_" + std::to_string(info.param);
}
INSTANTIATE_TEST_SUITE_P(Types, EveryType, testing::Range(std::size_t{0}, kTypes.size()), name_of);

}  // namespace
}  // namespace meld::reference
