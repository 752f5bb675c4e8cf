#include "compiler/check/scope.h"

#include <algorithm>
#include <set>

namespace meld::check {

using diagnostics::Kind;
using syntax::BinaryOp;

namespace {

struct Builtin {
    Op op;
    std::vector<Type> parameters;  // Error: int or float, the result is the wider of all such.
    Type result;
};
const std::map<std::string, Builtin> kBuiltins = {
    {"min", {Op::Min, {Type::Error, Type::Error}, Type::Error}}, {"max", {Op::Max, {Type::Error, Type::Error}, Type::Error}},
    {"abs", {Op::Abs, {Type::Error}, Type::Error}},              {"float", {Op::ToFloat, {Type::Int}, Type::Float}},
    {"int2float", {Op::ToFloat, {Type::Int}, Type::Float}},      {"truncate", {Op::Truncate, {Type::Float}, Type::Int}},
    {"float2int", {Op::Truncate, {Type::Float}, Type::Int}},     {"sqrt", {Op::Sqrt, {Type::Float}, Type::Float}},
    {"node2int", {Op::NodeToInt, {Type::Node}, Type::Int}}};

// The library of existing programs that this version does not have.
const std::set<std::string> kLater = {"llength", "lnth", "lappend", "lreverse", "lsort", "lexists", "ltake", "lremove", "lcount", "lreduce", "lunion", "ladd", "intpower", "randint", "randfloat",
                                      "int2str", "float2str", "str2int", "node2str", "normalize", "damp", "convolve", "divide", "addfloatlists", "residual", "random"};

std::string kind_of_value(const syntax::Expr& e) {
    if (std::holds_alternative<syntax::StringLiteral>(e.node)) return "a string";
    if (std::holds_alternative<syntax::WorldSize>(e.node)) return "`@world`";
    if (std::holds_alternative<syntax::RunArgument>(e.node)) return "a run argument";
    if (std::holds_alternative<syntax::Let>(e.node)) return "`let`";
    if (std::holds_alternative<syntax::ListValue>(e.node)) return "a list";
    if (std::holds_alternative<syntax::StructValue>(e.node)) return "a struct";
    if (std::holds_alternative<syntax::TupleValue>(e.node)) return "a tuple";
    return "this kind of value";
}

bool numeric(const Type& t) { return t.numeric() || t == Type::Error; }

}  // namespace

Names::Names(const Program& program, const syntax::Tree& source) : tree(source) {
    for (const PredicateId id : program.predicates.ids()) predicates.emplace(std::pair(program.predicates[id].name, program.predicates[id].arguments.size()), id);
    for (const ConstantId id : program.constants.ids()) constants.emplace(program.constants[id].name, id);
}

VariableId Scope::variable(const std::string& name, Span span) {
    const auto found = variables_.find(name);
    if (found != variables_.end()) return found->second;
    return variables_[name] = rule_.variables.add({name, span, Type::Error});
}

VariableId Scope::fresh(const std::string& name, const Type& type, Span span) { return rule_.variables.add({name, span, type}); }

const std::string* Scope::variable_name(const syntax::Expr& e) const {
    if (const auto* v = std::get_if<syntax::Variable>(&e.node)) return &v->name;
    if (const auto* c = std::get_if<syntax::Call>(&e.node); c != nullptr && !c->parentheses && lower_case_variables_ && !names_.constants.contains(c->name) && !names_.tree.is_lost(c->name))
        return &c->name;
    return nullptr;
}

bool Scope::compatible(const Type& a, const Type& b) { return a == b || a == Type::Error || b == Type::Error || (numeric(a) && numeric(b)); }

Type Scope::infer(const syntax::Expr& e) const {
    if (const std::string* name = variable_name(e)) {
        const auto found = variables_.find(*name);
        return found == variables_.end() ? Type::Error : rule_.variables[found->second].type;
    }
    if (std::holds_alternative<syntax::IntLiteral>(e.node)) return Type::Int;
    if (std::holds_alternative<syntax::FloatLiteral>(e.node)) return Type::Float;
    if (std::holds_alternative<syntax::BoolLiteral>(e.node)) return Type::Bool;
    if (std::holds_alternative<syntax::CatomLiteral>(e.node)) return Type::Node;
    if (const auto* c = std::get_if<syntax::Call>(&e.node)) {
        if (!c->parentheses) {
            const auto constant = names_.constants.find(c->name);
            return constant == names_.constants.end() ? Type::Error : program_.constants[constant->second].type;
        }
        const auto builtin = kBuiltins.find(c->name);
        if (builtin == kBuiltins.end()) return Type::Error;
        if (builtin->second.result != Type::Error || c->arguments.empty()) return builtin->second.result;
        for (const auto& argument : c->arguments)
            if (infer(*argument) == Type::Float) return Type::Float;
        return infer(*c->arguments[0]);
    }
    if (const auto* u = std::get_if<syntax::Unary>(&e.node)) return u->op == syntax::UnaryOp::Not ? Type::Bool : infer(*u->operand);
    if (const auto* b = std::get_if<syntax::Binary>(&e.node)) {
        if (b->op >= BinaryOp::Equal) return Type::Bool;
        const Type l = infer(*b->left), r = infer(*b->right);
        if (l == Type::Error || r == Type::Error) return Type::Error;
        return l == Type::Float || r == Type::Float ? Type::Float : l;
    }
    if (const auto* c = std::get_if<syntax::Conditional>(&e.node)) {
        const Type t = infer(*c->then_value), f = infer(*c->else_value);
        return t == Type::Error || f == Type::Float ? f : t;
    }
    return Type::Error;
}

Term Scope::convert(Term term, const Type& wanted, const std::string& where) {
    if (wanted == Type::Error || term.type == Type::Error || term.type == wanted) return term;
    if (wanted == Type::Float && term.type == Type::Int) {
        Term wide;
        wide.op = Op::ToFloat;
        wide.type = Type::Float;
        wide.span = term.span;
        wide.operands.push_back(std::move(term));
        return wide;
    }
    auto& d = report_.add(Kind::TypeMismatch, term.span, fmt::format("{} needs {}, and this is {}", where, type_name(wanted), type_name(term.type)));
    if (term.is_variable()) d.labels.push_back({rule_.variables[term.variable].span, fmt::format("`{}` is {} here", rule_.variables[term.variable].name, type_name(term.type))});
    if (wanted == Type::Int && term.type == Type::Float) d.help = "write truncate(...) to drop the fraction";
    term.type = Type::Error;
    return term;
}

Term Scope::resolve(const syntax::Expr& e, const Type& wanted, const std::string& where, bool anonymous_fits) {
    if (std::holds_alternative<syntax::Anonymous>(e.node)) {
        Term term;
        term.span = e.span;
        term.type = wanted;
        if (!anonymous_fits) report_.add(Kind::UnboundVariable, e.span, fmt::format("`_` stands for any value, and {} needs one", where));
        return term;
    }
    if (const std::string* name = variable_name(e)) {
        Variable& v = rule_.variables[variable(*name, e.span)];
        if (v.type == Type::Error) v.type = wanted;
    }
    return convert(untyped(e), wanted, where);
}

Term Scope::untyped(const syntax::Expr& e) {
    Term term;
    term.span = e.span;
    if (const std::string* name = variable_name(e)) {
        term.op = Op::Variable;
        term.variable = variable(*name, e.span);
        term.type = rule_.variables[term.variable].type;
    } else if (const auto* i = std::get_if<syntax::IntLiteral>(&e.node)) {
        term.op = Op::Int;
        term.type = Type::Int;
        term.integer = i->value;
    } else if (const auto* f = std::get_if<syntax::FloatLiteral>(&e.node)) {
        term.op = Op::Float;
        term.type = Type::Float;
        term.real = f->value;
    } else if (const auto* b = std::get_if<syntax::BoolLiteral>(&e.node)) {
        term.op = Op::Bool;
        term.type = Type::Bool;
        term.integer = b->value;
    } else if (const auto* c = std::get_if<syntax::CatomLiteral>(&e.node)) {
        term.op = Op::Node;
        term.type = Type::Node;
        term.integer = c->id;
    } else if (const auto* call = std::get_if<syntax::Call>(&e.node)) {
        return name_or_call(*call, e.span);
    } else if (const auto* u = std::get_if<syntax::Unary>(&e.node)) {
        return unary(*u, e.span);
    } else if (const auto* bin = std::get_if<syntax::Binary>(&e.node)) {
        return binary(*bin, e.span);
    } else if (const auto* cond = std::get_if<syntax::Conditional>(&e.node)) {
        return conditional(*cond, e.span);
    } else if (std::holds_alternative<syntax::Anonymous>(e.node)) {
        report_.add(Kind::UnboundVariable, e.span, "`_` stands for any value, and an expression needs one");
    } else {
        return unsupported(e.span, kind_of_value(e));
    }
    return term;
}

Term Scope::unsupported(Span span, const std::string& what) {
    report_.add(Kind::NotSupportedYet, span, what + " is not compiled by this version").help = "values here are int, float, bool and node";
    Term term;
    term.span = span;
    return term;
}

Term Scope::name_or_call(const syntax::Call& call, Span span) {
    Term term;
    term.span = span;
    if (!call.parentheses) {
        const auto constant = names_.constants.find(call.name);
        if (constant != names_.constants.end()) {
            term.op = Op::Constant;
            term.constant = constant->second;
            term.type = program_.constants[constant->second].type;
            return term;
        }
        if (names_.tree.is_lost(call.name)) return term;
        std::vector<std::string> known;
        for (const auto& [name, id] : names_.constants) known.push_back(name);
        const std::string near = diagnostics::nearest_name(call.name, known);
        auto& d = report_.add(Kind::UnknownFunction, span, fmt::format("there is no constant `{}`", call.name));
        std::string upper = call.name;
        upper[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(upper[0])));
        d.help = near.empty() ? fmt::format("declare it with `const {} = ...`, or write the variable `{}` with a capital", call.name, upper)
                              : fmt::format("did you mean `{}`?", near);
        return term;
    }
    const auto found = kBuiltins.find(call.name);
    if (found == kBuiltins.end()) {
        if (kLater.contains(call.name)) {
            report_.add(Kind::NotSupportedYet, span, fmt::format("the function `{}` is not compiled by this version", call.name)).help =
                "functions here are abs, float, max, min, node2int, sqrt and truncate";
            return term;
        }
        if (names_.tree.is_lost(call.name)) return term;
        std::vector<std::string> known;
        for (const auto& [name, b] : kBuiltins) known.push_back(name);
        const std::string near = diagnostics::nearest_name(call.name, known);
        report_.add(Kind::UnknownFunction, span, fmt::format("there is no function `{}`", call.name)).help =
            near.empty() ? "functions here are abs, float, max, min, node2int, sqrt and truncate" : fmt::format("did you mean `{}`?", near);
        return term;
    }
    const Builtin& builtin = found->second;
    if (builtin.parameters.size() != call.arguments.size()) {
        report_.add(Kind::ArityMismatch, span, fmt::format("`{}` takes {} argument{}, and here {} {}", call.name, builtin.parameters.size(),
                                                           builtin.parameters.size() == 1 ? "" : "s", call.arguments.size() == 1 ? "is" : "are", call.arguments.size()));
        return term;
    }
    term.op = builtin.op;
    term.type = builtin.result;
    Type widest = Type::Int;
    for (const auto& argument : call.arguments) {
        const Type t = infer(*argument);
        if (t == Type::Float) widest = Type::Float;
        if (builtin.result == Type::Error && !numeric(t))
            report_.add(Kind::TypeMismatch, argument->span, fmt::format("`{}` needs a number, and this is {}", call.name, type_name(t)));
    }
    if (builtin.result == Type::Error) term.type = widest;
    for (std::size_t i = 0; i < call.arguments.size(); ++i)
        term.operands.push_back(resolve(*call.arguments[i], builtin.parameters[i] == Type::Error ? widest : builtin.parameters[i], fmt::format("`{}`", call.name)));
    // float(X) of a float is X itself.
    return term;
}

Term Scope::unary(const syntax::Unary& u, Span span) {
    Term term;
    term.span = span;
    if (u.op == syntax::UnaryOp::Not) {
        term.op = Op::Not;
        term.type = Type::Bool;
        term.operands.push_back(resolve(*u.operand, Type::Bool, "`~`"));
        return term;
    }
    Term operand = resolve(*u.operand, Type::Error, "`-`");
    if (!numeric(operand.type)) report_.add(Kind::TypeMismatch, operand.span, fmt::format("`-` needs a number, and this is {}", type_name(operand.type)));
    term.op = Op::Negate;
    term.type = operand.type;
    term.operands.push_back(std::move(operand));
    return term;
}

Term Scope::binary(const syntax::Binary& b, Span span) {
    static const std::map<BinaryOp, std::pair<Op, const char*>> ops = {
        {BinaryOp::Add, {Op::Add, "+"}},           {BinaryOp::Subtract, {Op::Subtract, "-"}},       {BinaryOp::Multiply, {Op::Multiply, "*"}},
        {BinaryOp::Divide, {Op::Divide, "/"}},     {BinaryOp::Modulo, {Op::Modulo, "%"}},           {BinaryOp::Power, {Op::Power, "^"}},
        {BinaryOp::Equal, {Op::Equal, "="}},       {BinaryOp::NotEqual, {Op::NotEqual, "<>"}},      {BinaryOp::Less, {Op::Less, "<"}},
        {BinaryOp::LessEqual, {Op::LessEqual, "<="}}, {BinaryOp::Greater, {Op::Greater, ">"}},      {BinaryOp::GreaterEqual, {Op::GreaterEqual, ">="}},
        {BinaryOp::And, {Op::And, "&&"}},          {BinaryOp::Or, {Op::Or, "||"}}};
    const auto found = ops.find(b.op);
    if (found == ops.end()) return unsupported(span, "appending lists");
    const auto [op, sign] = found->second;
    const std::string where = fmt::format("`{}`", sign);
    Term term;
    term.span = span;
    term.op = op;
    if (op == Op::And || op == Op::Or) {
        term.type = Type::Bool;
        term.operands.push_back(resolve(*b.left, Type::Bool, where));
        term.operands.push_back(resolve(*b.right, Type::Bool, where));
        return term;
    }
    const Type l = infer(*b.left), r = infer(*b.right);
    const bool comparison = op >= Op::Equal && op <= Op::GreaterEqual;
    if (!compatible(l, r)) {
        auto& d = report_.add(Kind::TypeMismatch, span, fmt::format("{} cannot {} {} and {}", where, comparison ? "compare" : "combine", type_name(l), type_name(r)));
        d.labels.push_back({b.left->span, "this is " + type_name(l)});
        d.labels.push_back({b.right->span, "this is " + type_name(r)});
        return term;
    }
    const Type common = l == Type::Float || r == Type::Float ? Type::Float : l == Type::Error ? r : l;
    if (!comparison && !numeric(common))
        report_.add(Kind::TypeMismatch, span, fmt::format("{} needs numbers, and these are {}", where, type_name(common))).help =
            common == Type::Node ? "node2int(X) gives a catom's number" : "";
    term.type = comparison ? Type::Bool : common;
    term.operands.push_back(resolve(*b.left, common, where));
    term.operands.push_back(resolve(*b.right, common, where));
    return term;
}

Term Scope::conditional(const syntax::Conditional& c, Span span) {
    Term term;
    term.span = span;
    term.op = Op::If;
    const Type t = infer(*c.then_value), f = infer(*c.else_value);
    if (!compatible(t, f))
        report_.add(Kind::TypeMismatch, span, "both sides of `if` must have one type").labels = {{c.then_value->span, "this is " + type_name(t)},
                                                                                               {c.else_value->span, "this is " + type_name(f)}};
    term.type = !compatible(t, f) ? Type::Error : t == Type::Float || f == Type::Float ? Type::Float : t == Type::Error ? f : t;
    term.operands.push_back(resolve(*c.condition, Type::Bool, "`if`"));
    term.operands.push_back(resolve(*c.then_value, term.type, "`then`"));
    term.operands.push_back(resolve(*c.else_value, term.type, "`else`"));
    return term;
}

}  // namespace meld::check
