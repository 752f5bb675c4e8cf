// Emits the functions of a program: static C++ functions that may call each other in any order.
#include <algorithm>

#include "compiler/emit/writer.h"

namespace meld::emit {

using namespace check;

std::string function_name(const Program& program, FunctionId id) {
    const Function& f = program.functions[id];
    return fmt::format("{}_{}_{}", f.external ? "extern" : "fun", clean(f.name), id.index());
}

namespace {

// Whether an extern makes values of more than one word: then it is told where.
bool makes_lists(const Function& f) { return f.result.compound(); }

void emit_extern(const plan::Plan& plan, FunctionId id, Writer& w) {
    const Function& f = plan.program.functions[id];
    std::string parameters = makes_lists(f) ? "Eval*" : "";
    for (const Variable& v : f.variables) parameters += (parameters.empty() ? "" : ", ") + cpp_type(v.type);
    // The label keeps a name that is a word of C++, or one of ours, from meeting it.
    w.line("extern \"C\" {} {}({}) __asm__({});", cpp_type(f.result), function_name(plan.program, id), parameters, quoted(f.name));
}

std::string signature(const plan::Plan& plan, FunctionId id) {
    const Function& f = plan.program.functions[id];
    std::string text = fmt::format("static {} {}([[maybe_unused]] Self& s, [[maybe_unused]] u32 rule", cpp_type(f.result), function_name(plan.program, id));
    for (std::size_t i = 0; i < f.parameter_count; ++i) {
        const Variable& v = f.variables[VariableId(i)];
        text += fmt::format(", [[maybe_unused]] {} {}_{}", cpp_type(v.type), clean(v.name), i);
    }
    return text + ")";
}

void emit_function(const plan::Plan& plan, FunctionId id, Writer& w) {
    const Function& f = plan.program.functions[id];
    Rule makeshift;
    makeshift.name = f.name;
    makeshift.variables = f.variables;
    Scope scope{plan, makeshift, 0};
    scope.caller = "rule";
    for (std::size_t i = 0; i < f.parameter_count; ++i) scope.values.insert(VariableId(i));
    w.raw("");
    w.open(signature(plan, id) + " {");
    w.raw("const OpenCall call(*s.e, rule, &s);");
    w.raw("if (call.refused) return {};");
    w.line("return {};", term_as(scope, f.body, f.result));
    w.close();
}

}  // namespace

void emit_functions(const plan::Plan& plan, Writer& w) {
    const Table<Function>& functions = plan.program.functions;
    if (!functions.empty()) w.raw("");
    for (const FunctionId id : functions.ids())
        if (!functions[id].external) w.raw(signature(plan, id) + ";");
    for (const FunctionId id : functions.ids())
        if (!functions[id].external) emit_function(plan, id, w);
}

void emit_externs(const plan::Plan& plan, Writer& w) {
    const auto& functions = plan.program.functions;
    if (std::none_of(functions.begin(), functions.end(), [](const Function& f) { return f.external; })) return;
    w.raw("// Memory for what externs make; see meld/extern.h.");
    w.raw("extern \"C\" void* meld_allocate(Eval* e, u64 bytes) { return scratch(*e, bytes); }");
    for (const FunctionId id : plan.program.functions.ids())
        if (plan.program.functions[id].external) emit_extern(plan, id, w);
}

std::string call(const Scope& scope, FunctionId id, const std::vector<Term>& operands) {
    std::vector<std::string> values;
    for (std::size_t i = 0; i < operands.size(); ++i) values.push_back(term_as(scope, operands[i], scope.plan.program.functions[id].variables[VariableId(i)].type));
    return call_with(scope, id, values);
}

std::string call_with(const Scope& scope, FunctionId id, const std::vector<std::string>& values) {
    const Function& f = scope.plan.program.functions[id];
    std::string arguments = f.external ? makes_lists(f) ? "s.e" : "" : "s, " + scope.site();
    for (const std::string& value : values) arguments += (arguments.empty() ? "" : ", ") + value;
    const std::string text = fmt::format("{}({})", function_name(scope.plan.program, id), arguments);
    // What another language made is looked at once: no NaN in facts, sets in order.
    return f.external ? fmt::format("checked_extern(*s.e, {}, kTypes, {}, {})", scope.site(), type_symbol(f.result), text) : text;
}

}  // namespace meld::emit
