#include "compiler/check/program/library_fold.h"

#include <algorithm>

#include "compiler/check/program/types.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

bool fits_letter(char letter, const Type& type) {
    const bool of_floats = type.kind == Type::Kind::Struct &&
                           std::all_of(type.parts.begin(), type.parts.end(), [](const Type& t) { return t == Type::Float; });
    switch (letter) {
        case 'N':
            return type.numeric();
        case 'S':
            return of_floats;
        case 'R':
            return of_floats || type == Type::list_of(Type::Float);
        default:
            return true;
    }
}

}  // namespace

std::optional<Type> type_of_library_fold(const std::string& name, const Type& value) {
    const LibraryFunction* f = library_function(name, 2);
    if (f == nullptr || f->parameters.size() != 2 || f->random || has_unknown(value)) return std::nullopt;
    LibraryBindings bindings;
    for (const LibraryType& parameter : f->parameters)
        if (!match(parameter, value, bindings)) return std::nullopt;
    for (const auto& [letter, type] : bindings)
        if (!fits_letter(letter, type)) return std::nullopt;
    Type type = substitute(f->result, bindings);
    for (const LibraryType& parameter : f->parameters)
        if (!(substitute(parameter, bindings) == type)) return std::nullopt;
    return type;
}

std::optional<FunctionId> library_fold(Program& program, const std::string& name, const Type& value, Span span) {
    const std::optional<Type> type = type_of_library_fold(name, value);
    if (!type) return std::nullopt;
    for (const FunctionId id : program.functions.ids())
        if (const Function& f = program.functions[id]; f.of_library && f.name == name && f.result == *type) return id;
    const LibraryFunction& called = *library_function(name, 2);
    Function f;
    f.name = name;
    f.span = span;
    f.parameter_count = 2;
    f.result = *type;
    f.of_library = true;
    f.body = {.op = called.op, .type = *type, .span = span};
    if (called.op == Op::Library) f.body.text = called.name;
    for (const char* parameter : {"SoFar", "Value"}) {
        const VariableId v = f.variables.add({parameter, span, *type});
        f.body.operands.push_back({.op = Op::Variable, .type = *type, .span = span, .variable = v});
    }
    return program.functions.add(std::move(f));
}

void refuse_library_fold(const LibraryFunction& f, const Type& value, Span span, diagnostics::Reporter& report) {
    report
        .add(Kind::TypeMismatch, span,
             fmt::format("`{}` is {}, so it does not make one {} of two", f.name, f.signature,
                         has_unknown(value) ? "value" : type_name(value)))
        .help = "fold with a function that takes the value so far and the next one, and returns a value of the same type";
}

}  // namespace meld::check
