// Emits the functions of a program: static C++ functions that may call each other in any order.
#include <algorithm>
#include <string_view>
#include <vector>

#include "compiler/check/program/library.h"
#include "compiler/emit/writer.h"

namespace meld::emit {

using namespace check;

std::string constant_name(const Program& program, ConstantId id) {
    return fmt::format("constant_{}_{}", clean(program.constants[id].name), id.index());
}

bool computed_once(const Constant& c) { return c.computed.valid() && !c.type.compound(); }

std::string function_name(const Program& program, FunctionId id) {
    const Function& f = program.functions[id];
    return fmt::format("{}_{}_{}", f.external ? "extern" : "fun", clean(f.name), id.index());
}

namespace {

// Whether an extern returns values of more than one word: it then gets memory for them.
bool makes_lists(const Function& f) { return f.result.compound(); }

void emit_extern(const plan::Plan& plan, FunctionId id, Writer& w) {
    const Function& f = plan.program.functions[id];
    std::string parameters = makes_lists(f) ? "Eval*" : "";
    for (const Variable& v : f.variables) parameters += (parameters.empty() ? "" : ", ") + cpp_type(v.type);
    // The label keeps a name from clashing with a C++ keyword or one of our names.
    w.line("extern \"C\" {} {}({}) __asm__({});", cpp_type(f.result), function_name(plan.program, id), parameters, quoted(f.name));
}

std::string signature(const plan::Plan& plan, FunctionId id) {
    const Function& f = plan.program.functions[id];
    std::string text = fmt::format("{} {} {}([[maybe_unused]] Self& s, [[maybe_unused]] u32 rule",
                                   plan.in_pieces() ? "" : linkage(plan, plan.program.functions.count()), cpp_type(f.result),
                                   function_name(plan.program, id));
    for (std::size_t i = 0; i < f.parameter_count; ++i) {
        const Variable& v = f.variables[VariableId(i)];
        text += fmt::format(", [[maybe_unused]] {} {}_{}", cpp_type(v.type), clean(v.name), i);
    }
    return text + ")";
}

// Which lists a function that ends by calling itself walks along: it uses only the head, the length and whether there is any element, and
// passes on the tail, or the same list, as the same argument. Such a list is a position and a remaining length, and needs no memory for its
// tails.
class Walks {
  public:
    Walks(FunctionId id, const Function& f) : id_(id), f_(f), held_(f.parameter_count), stepped_(f.parameter_count) { end(f.body); }

    bool walked(std::size_t parameter) const { return stepped_[parameter] && !held_[parameter]; }
    static bool is_tail(const Term& t) { return is_library(t, "tail"); }

  private:
    static bool is_library(const Term& t, std::string_view name) {
        if (t.op != Op::Library || t.operands.size() != 1 || !t.operands[0].is_variable()) return false;
        const LibraryFunction* f = library_function(t.text, 1);
        return f != nullptr && f->cpp == name;
    }
    static bool is_empty(const Term& t) { return t.op == Op::List && t.operands.empty(); }
    static bool is_look(const Term& t) {
        if (t.op == Op::Equal || t.op == Op::NotEqual) return is_empty(t.operands[0]) || is_empty(t.operands[1]);
        return is_library(t, "first") || is_library(t, "length");
    }

    // Where the function ends, as Body::give() has it.
    void end(const Term& t) {
        switch (t.op) {
            case Op::If:
                return look(t.operands[0]), end(t.operands[1]), end(t.operands[2]);
            case Op::Let:
            case Op::And:
            case Op::Or:
                return look(t.operands[0]), end(t.operands[1]);
            default:
                break;
        }
        if (t.op != Op::Call || t.function != id_) return look(t);
        for (std::size_t i = 0; i < f_.parameter_count; ++i) {
            const Term& next = t.operands[i];
            if (next.is_variable() && next.variable.index() == i) continue;
            if (is_tail(next) && next.operands[0].variable.index() == i) {
                stepped_[i] = true;
                continue;
            }
            held_[i] = true;  // It continues with another list.
            look(next);
        }
    }
    void look(const Term& t) {
        if (t.is_variable() && t.variable.index() < held_.size()) held_[t.variable.index()] = true;
        const bool only_looks = is_look(t);
        for (const Term& operand : t.operands)
            if (!only_looks || !operand.is_variable()) look(operand);
    }

    FunctionId id_;
    const Function& f_;
    std::vector<bool> held_, stepped_;
};

// The body as statements, in which each path ends in a return, or in another round of the function where it calls itself at its end.
class Body {
  public:
    Body(FunctionId id, const Function& f, Writer& w) : id_(id), f_(f), w_(w), walks_(id, f) {}

    // The function as rounds, of which give() writes one.
    void repeat(const Scope& scope) {
        for (std::size_t i = 0; i < f_.parameter_count; ++i) {
            if (!walks_.walked(i)) continue;
            w_.line("List walk_{} = contents({});", i, scope.local(VariableId(i)));
            w_.line("{} = &walk_{};", scope.local(VariableId(i)), i);
        }
        w_.open("for (;;) {");
        give(scope, f_.body);
        w_.close();
    }

    bool calls_itself(const Term& t) const {
        switch (t.op) {
            case Op::If:
                return calls_itself(t.operands[1]) || calls_itself(t.operands[2]);
            case Op::Let:
                return calls_itself(t.operands[1]);
            case Op::And:
            case Op::Or:
                return calls_itself(t.operands[1]);
            case Op::Call:
                return t.function == id_ && t.type == f_.result;
            default:
                return false;
        }
    }
    // The value of `t` is the value of the function.
    void give(const Scope& scope, const Term& t) {
        if (!calls_itself(t)) return w_.line("return {};", term_as(scope, t, f_.result));
        const auto choose = [&](const std::string& condition, const auto& yes, const auto& no) {
            w_.open(fmt::format("if ({}) {{", condition));
            yes();
            w_.close();
            no();
        };
        switch (t.op) {
            case Op::If:
                return choose(term(scope, t.operands[0]), [&] { give(scope, t.operands[1]); }, [&] { give(scope, t.operands[2]); });
            case Op::And:
                return choose(
                    "!(" + term(scope, t.operands[0]) + ")", [&] { w_.raw("return false;"); }, [&] { give(scope, t.operands[1]); });
            case Op::Or:
                return choose(term(scope, t.operands[0]), [&] { w_.raw("return true;"); }, [&] { give(scope, t.operands[1]); });
            case Op::Let: {
                Scope inner = scope;
                inner.values.insert(t.variable);
                const Type& type = scope.rule.variables[t.variable].type;
                w_.line("const {} {} = {};", cpp_type(type), scope.local(t.variable), term_as(scope, t.operands[0], type));
                return give(inner, t.operands[1]);
            }
            default:
                return again(scope, t);
        }
    }

  private:
    void again(const Scope& scope, const Term& t) {
        for (std::size_t i = 0; i < f_.parameter_count; ++i) {
            const Type& type = f_.variables[VariableId(i)].type;
            if (!walks_.walked(i)) w_.line("const {} next_{} = {};", cpp_type(type), i, term_as(scope, t.operands[i], type));
        }
        for (std::size_t i = 0; i < f_.parameter_count; ++i) {
            if (!walks_.walked(i))
                w_.line("{} = next_{};", scope.local(VariableId(i)), i);
            else if (Walks::is_tail(t.operands[i]))
                w_.line("step(walk_{});", i);
        }
        w_.raw("if (!call.again(rule)) return {};");
        w_.raw("continue;");
    }

    FunctionId id_;
    const Function& f_;
    Writer& w_;
    Walks walks_;
};

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
    w.line("{} call(*s.e, rule, &s, s.calls);", f.result.compound() ? "OpenCall" : "WordCall");
    w.raw("if (call.refused) return {};");
    Body body(id, f, w);
    if (body.calls_itself(f.body))
        body.repeat(scope);
    else
        body.give(scope, f.body);
    w.close();
}

// The value of a constant that only the run can compute, once for the catoms that are evaluated together. It traps where its function
// does, and does not count as a call of the catom that happens to come first.
void emit_constants(const plan::Plan& plan, Writer& w) {
    for (const ConstantId id : plan.program.constants.ids()) {
        const Constant& c = plan.program.constants[id];
        if (!computed_once(c)) continue;
        const std::string name = constant_name(plan.program, id);
        w.part(name);
        w.open(fmt::format("{}{} {}_value(Self& s, u32 rule) {{", shared(plan), cpp_type(c.type), name));
        w.line("if (s.{}.known) return s.{}.value;", name, name);
        w.raw("const u64 calls = s.calls;");
        w.raw("s.calls = 0;");
        w.line("s.{}.value = {}(s, rule);", name, function_name(plan.program, c.computed));
        w.raw("s.calls = calls;");
        w.line("s.{}.known = s.e->trap == Trap::None;", name);
        w.line("return s.{}.value;", name);
        w.close();
    }
}

}  // namespace

void emit_functions(const plan::Plan& plan, Writer& w) {
    const Table<Function>& functions = plan.program.functions;
    if (!functions.empty()) w.raw("");
    for (const FunctionId id : functions.ids())
        if (!functions[id].external) w.raw(signature(plan, id) + ";");
    for (const ConstantId id : plan.program.constants.ids())
        if (computed_once(plan.program.constants[id]))
            w.line("{}{} {}_value(Self& s, u32 rule);", shared(plan), cpp_type(plan.program.constants[id].type),
                   constant_name(plan.program, id));
    for (const FunctionId id : functions.ids())
        if (!functions[id].external) {
            w.part("function " + functions[id].name);
            emit_function(plan, id, w);
        }
    emit_constants(plan, w);
    w.part("");
}

void emit_externs(const plan::Plan& plan, Writer& w) {
    const auto& functions = plan.program.functions;
    if (std::none_of(functions.begin(), functions.end(), [](const Function& f) { return f.external; })) return;
    w.raw("// Memory for what externs make; see meld/extern.h.");
    const std::string allocate = "extern \"C\" void* meld_allocate(Eval* e, u64 bytes)";
    w.part("externs");
    w.raw(allocate + " { return scratch(*e, bytes); }");
    w.part("");
    for (const FunctionId id : plan.program.functions.ids())
        if (plan.program.functions[id].external) emit_extern(plan, id, w);
}

std::string call(const Scope& scope, FunctionId id, const std::vector<Term>& operands) {
    std::vector<std::string> values;
    for (std::size_t i = 0; i < operands.size(); ++i)
        values.push_back(term_as(scope, operands[i], scope.plan.program.functions[id].variables[VariableId(i)].type));
    return call_with(scope, id, values);
}

std::string call_with(const Scope& scope, FunctionId id, const std::vector<std::string>& values) {
    const Function& f = scope.plan.program.functions[id];
    std::string arguments = f.external ? makes_lists(f) ? "s.e" : "" : "s, " + scope.site();
    for (const std::string& value : values) arguments += (arguments.empty() ? "" : ", ") + value;
    const std::string text = fmt::format("{}({})", function_name(scope.plan.program, id), arguments);
    // Values from another language are checked once: no NaN in facts, sets sorted.
    return f.external ? fmt::format("checked_extern(*s.e, {}, kTypes, {}, {})", scope.site(), type_symbol(f.result), text) : text;
}

}  // namespace meld::emit
