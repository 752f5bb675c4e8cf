// Terms of calls: functions of the program first, then those of the library.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "compiler/check/names/scope.h"
#include "compiler/syntax/other_languages.h"
#include "compiler/syntax/parse.h"

namespace meld::check {

using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

namespace {

constexpr const char* kProcessors = "programs cannot tell processors apart; results do not depend on them";

bool is_struct_of_floats(const Type& type) {
    return type == Type::Error || (type.kind == Type::Kind::Struct && std::all_of(type.parts.begin(), type.parts.end(), [](const Type& t) {
                                       return t == Type::Float || t == Type::Error;
                                   }));
}

}  // namespace

Term Scope::call(const std::string& name, const Arguments& arguments, Span span, const Type& wanted) {
    if (const auto own = names_.functions.find(name); own != names_.functions.end()) return call_function(own->second, arguments, span);
    if (const LibraryFunction* f = library_function(name, arguments.size())) return call_library(*f, arguments, span, wanted);
    if (name == "+00" || name == "-00") return extreme(name[0] == '+', span, wanted);
    if (std::optional<Term> known = scheduling(name, arguments, span)) return *known;
    return unknown_function(name, arguments, span, wanted);
}

// +00 and -00: the greatest and the least number of the type that the place wants, an int where nothing else is known.
Term Scope::extreme(bool greatest, Span span, const Type& wanted) {
    Term term;
    term.span = span;
    term.op = wanted == Type::Float ? Op::Float : Op::Int;
    term.type = wanted == Type::Float ? Type::Float : Type::Int;
    term.real = greatest ? std::numeric_limits<double>::max() : std::numeric_limits<double>::lowest();
    term.integer = greatest ? std::numeric_limits<std::int64_t>::max() : std::numeric_limits<std::int64_t>::min();
    return term;
}

// Linear Meld's functions about the processor of a node: here all nodes are on one, which changes no result.
std::optional<Term> Scope::scheduling(const std::string& name, const Arguments& arguments, Span span) {
    Term term;
    term.span = span;
    if (name == "@thread" || name == "@host") {
        report_
            .add(Kind::UnknownFunction, span,
                 fmt::format("`{}` is the node that a rule is about, and this one is about none or several", name))
            .help = "write the node itself";
        term.type = Type::Error;
        return term;
    }
    if (name == "@cpus" || name == "@threads") {
        term.op = Op::Int;
        term.type = Type::Int;
        term.integer = 1;
        auto& d = report_.add(Kind::HintIgnored, span, fmt::format("`{}` is 1 here", name));
        d.help = kProcessors;
        d.fixes = {safe(diagnostics::write(span, "1"))};
        return term;
    }
    const bool number = name == "cpu-id" || name == "cpu-static", flag = name == "is-static" || name == "is-moving";
    if ((!number && !flag) || arguments.size() != 1 || names_.tree.is_lost(name)) return std::nullopt;
    resolve(*arguments[0], Type::Node, fmt::format("`{}`", name));
    term.op = number ? Op::Int : Op::Bool;
    term.type = number ? Type::Int : Type::Bool;
    auto& d = report_.add(Kind::HintIgnored, span, fmt::format("`{}` is {} for every catom here", name, number ? "0" : "false"));
    d.help = kProcessors;
    d.fixes = {diagnostics::write(span, number ? "0" : "false")};
    return term;
}

bool Scope::is_function(const std::string& name) const { return names_.functions.contains(name) || library_function(name, 0) != nullptr; }

Term Scope::condition(const syntax::Atom& atom) {
    return convert(call(atom.name.text, atom.arguments, atom.span, Type::Bool), Type::Bool, "a condition");
}

Term Scope::unknown_function(const std::string& name, const Arguments& arguments, Span span, const Type& wanted) {
    Term term;
    term.span = span;
    if (names_.tree.is_lost(name)) return term;
    for (const auto& [key, id] : names_.predicates)
        if (key.first == name) {
            auto& d = report_.add(Kind::UnknownFunction, span,
                                  fmt::format("`{}` is a predicate: its facts hold or do not, and have no value", name));
            d.help = fmt::format("make it a separate clause, `{0}(...)` or `not {0}(...)`", name);
            d.labels = {{program_.predicates[id].span, "declared here"}};
            return term;
        }
    if (name == "priority" && arguments.size() == 1) {
        report_.add(Kind::UnknownFunction, span, "catoms have no priority").help =
            "leave the condition out, and let the rules say what it would have excluded";
        return term;
    }
    // Special forms with something missing.
    if (name == "proved" && arguments.size() <= 2) {
        const std::string predicate = arguments.empty() ? "p" : syntax::print(*arguments.back());
        report_.add(Kind::UnknownFunction, span, "`proved` counts the facts of a predicate at a catom").help =
            fmt::format("write `proved(A, {})`", predicate.substr(0, predicate.find('(')));
        return term;
    }
    if (name == "delta" && arguments.size() == 1) {
        report_.add(Kind::UnknownFunction, span, "`delta` first names the argument that changes").help =
            fmt::format("write `delta(X; {})`, where X is that argument", syntax::print(*arguments[0]));
        return term;
    }
    if (is_older(name)) {
        report_.add(Kind::UnknownFunction, span, fmt::format("`{}` is in the library of functions for programs of Linear Meld", name))
            .help = kUseOlder;
        return term;
    }
    if (const MachineState* state = machine_state(name)) {
        report_.add(Kind::UnknownFunction, span, fmt::format("`{}` tells of the machine of Linear Meld, and there is none here", name))
            .help = state->cure;
        return term;
    }
    std::vector<std::string> known;
    for (const LibraryFunction& f : library()) known.push_back(f.name);
    for (const auto& [own, id] : names_.functions) known.push_back(own);
    // Its name in other languages.
    static const std::map<std::string, std::string> elsewhere = {{"len", "llength"},    {"length", "llength"}, {"size", "llength"},
                                                                 {"random", "randint"}, {"rand", "randint"},   {"str", "int2str"}};
    static const std::set<std::string> aggregates = {"count", "avg", "average", "mean", "collect"};
    if (aggregates.contains(name) && !names_.functions.contains(name)) {
        report_.add(Kind::UnknownFunction, span, fmt::format("there is no function `{}`", name)).help = syntax::kAggregateClause;
        return term;
    }
    const auto other = elsewhere.find(name);
    const std::string near = other != elsewhere.end() ? other->second : diagnostics::nearest_name(name, known);
    auto& d = report_.add(Kind::UnknownFunction, span, fmt::format("there is no function `{}`", name));
    if (near.empty())
        d.help = fmt::format("declare it, `fun {0}({1}) : {3} = ...`, or, if it is written in C, `extern {3} {0}({2}).`", name,
                             parameters(arguments, Named::Yes), parameters(arguments, Named::No),
                             has_unknown(wanted) || wanted == Type::Error ? "int" : type_name(wanted));
    else
        d.did_you_mean(near, span, Fit::Name);
    return term;
}

// The arguments of a call as a declaration would list them.
std::string Scope::parameters(const Arguments& arguments, Named named) {
    std::string text;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const Type type = infer(*arguments[i]);
        text += fmt::format("{}{}", i == 0 ? "" : ", ", has_unknown(type) ? "int" : type_name(type));
        if (named == Named::Yes) text += " " + std::string(1, static_cast<char>('A' + i % 26));
    }
    return text;
}

void Scope::wrong_count(const std::string& name, std::size_t needs, std::size_t given, Span span, Span declared) {
    auto& d = report_.add(
        Kind::ArityMismatch, span,
        fmt::format("`{}` takes {} argument{}, and here {} {}", name, needs, needs == 1 ? "" : "s", given == 1 ? "is" : "are", given));
    if (declared.end > declared.begin) d.labels.push_back({declared, "declared here"});
}

Term Scope::call_function(FunctionId id, const Arguments& arguments, Span span) {
    const Function& f = program_.functions[id];
    Term term;
    term.span = span;
    if (f.parameter_count != arguments.size()) {
        wrong_count(f.name, f.parameter_count, arguments.size(), span, f.span);
        return term;
    }
    term.op = Op::Call;
    term.function = id;
    term.type = f.result;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const Variable& parameter = f.variables[VariableId(i)];
        term.operands.push_back(
            resolve(*arguments[i], parameter.type, fmt::format("argument {} of `{}`", i + 1, f.name), false, parameter.span));
    }
    return term;
}

Term Scope::call_library(const LibraryFunction& f, const Arguments& arguments, Span span, const Type& wanted) {
    Term term;
    term.span = span;
    const std::string where = fmt::format("`{}`", f.name);
    if (f.parameters.size() != arguments.size()) {
        wrong_count(f.name, f.parameters.size(), arguments.size(), span, {});
        return term;
    }
    LibraryBindings bindings;
    const std::size_t errors = report_.error_count();
    bool fit = true;
    for (std::size_t i = 0; i < f.parameters.size(); ++i) fit = match(f.parameters[i], infer(*arguments[i]), bindings) && fit;
    // Only the context tells what the elements in `lreverse([])` are.
    if (fit && has_unknown(substitute(f.result, bindings))) match(f.result, wanted, bindings);
    term.op = f.op;
    if (f.op == Op::Library) term.text = f.name;
    for (std::size_t i = 0; i < f.parameters.size(); ++i) {
        term.operands.push_back(resolve(*arguments[i], substitute(f.parameters[i], bindings), where));
        match(f.parameters[i], term.operands.back().type, bindings);
    }
    if (const auto number = bindings.find('N'); number != bindings.end() && !number->second.numeric() && number->second != Type::Error)
        report_
            .add(Kind::TypeMismatch, arguments[0]->span,
                 fmt::format("`{}` needs {}, and this is {}", f.name, f.parameters[0].variable == 'N' ? "a number" : "numbers",
                             type_name(infer(*arguments[0]))))
            .help = fmt::format("`{}` is {}", f.name, f.signature);
    if (const auto record = bindings.find('S'); record != bindings.end() && !is_struct_of_floats(record->second))
        report_.add(Kind::TypeMismatch, arguments.back()->span,
                    fmt::format("`{}` needs a struct of floats, and this is {}", f.name, type_name(record->second)));
    if (const auto table = bindings.find('R');
        table != bindings.end() && !is_struct_of_floats(table->second) && table->second != Type::list_of(Type::Float))
        report_.add(Kind::TypeMismatch, arguments[0]->span,
                    fmt::format("`{}` needs a list or a struct of floats, and this is {}", f.name, type_name(table->second)));
    // A call with an error has any type, so that one mistake gives one message.
    term.type = report_.error_count() > errors ? Type::Error : substitute(f.result, bindings);
    return term;
}

}  // namespace meld::check
