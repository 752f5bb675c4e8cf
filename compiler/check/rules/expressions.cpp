// Terms of operators, conditionals, lists, structs, `let`, names and run arguments.
#include <algorithm>

#include "compiler/check/names/scope.h"
#include "compiler/check/program/fact_form.h"
#include "compiler/check/program/operators.h"
#include "compiler/syntax/operators.h"
#include "compiler/syntax/parse.h"

namespace meld::check {

using diagnostics::Kind;
using syntax::BinaryOp;

namespace {

bool maybe_number(const Type& t) { return t.numeric() || t == Type::Error; }
bool holds_elements(const Type& t) { return t.kind == Type::Kind::List || t.kind == Type::Kind::Set || t.kind == Type::Kind::Array; }

}  // namespace

// ---- operators

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
    if (!maybe_number(operand.type) && operand.type != Type::Vec3)
        report_.add(Kind::TypeMismatch, operand.span, fmt::format("`-` needs a number, and this is {}", type_name(operand.type)));
    term.op = Op::Negate;
    term.type = operand.type;
    term.operands.push_back(std::move(operand));
    return term;
}

namespace {

// As the right operand of an operator.
std::string right_operand(const syntax::Expr& e) {
    const bool operators = std::holds_alternative<syntax::Binary>(e.node) || std::holds_alternative<syntax::Chain>(e.node);
    return operators ? fmt::format("({})", syntax::print(e)) : syntax::print(e);
}

// The call that converts a value to a string; empty if there is none.
std::string as_text(const syntax::Expr& e, const Type& type) {
    const char* function = type == Type::Int ? "int2str" : type == Type::Float ? "float2str" : type == Type::Node ? "node2str" : nullptr;
    return function == nullptr ? "" : fmt::format("{}({})", function, syntax::print(e));
}

// What joins a string and a value of another type.
void suggest_joining(diagnostics::Diagnostic& d, const syntax::Expr& l, const syntax::Expr& r, Span span, const Type& left,
                     const Type& right) {
    const std::string first = left == Type::String ? syntax::print(l) : as_text(l, left),
                      second = right == Type::String ? right_operand(r) : as_text(r, right);
    if (first.empty() || second.empty()) return;
    std::string joined = fmt::format("{} ++ {}", first, second);
    d.help = fmt::format("write `{}`", joined);
    d.fixes = {diagnostics::write(span, std::move(joined))};
}

std::string where_of(Op op) { return fmt::format("`{}`", sign_of(op)); }

}  // namespace

Term Scope::left_operand(Left left, const Type& wanted, const std::string& where) {
    return left.text != nullptr ? resolve(*left.text, wanted, where) : convert(std::move(left.made), wanted, where);
}

std::optional<Type> Scope::common_type(Op op, const Left& left, const syntax::Expr& right, const Type& right_type, Span span) {
    const std::string where = where_of(op);
    const Type &l = left.type, &r = right_type;
    const std::optional<Type> common = join(l, r);
    if (!common) {
        auto& d = report_.add(
            Kind::TypeMismatch, span,
            fmt::format("{} cannot {} {} and {}", where, is_comparison(op) ? "compare" : "combine", type_name(l), type_name(r)));
        d.labels.push_back({left.span, "this is " + type_name(l)});
        d.labels.push_back({right.span, "this is " + type_name(r)});
        if ((op == Op::Append || op == Op::Add) && (l == Type::String || r == Type::String) && left.text != nullptr)
            suggest_joining(d, *left.text, right, span, l, r);
        return std::nullopt;
    }
    const bool vectors = *common == Type::Vec3 && (op == Op::Add || op == Op::Subtract);
    if (op == Op::Append) {
        if (*common != Type::String && *common != Type::Error && common->kind != Type::Kind::List && common->kind != Type::Kind::Array)
            report_.add(Kind::TypeMismatch, span, fmt::format("{} needs lists or strings, and these are {}", where, type_name(*common)))
                .help = common->kind == Type::Kind::Set ? "sunion(A, B) joins sets"
                        : common->numeric()             ? "write int2str(...) or float2str(...) around a number, or [X] for a list of it"
                                                        : "";
    } else if (!is_comparison(op)) {
        if (!maybe_number(*common) && !vectors) {
            auto& d = report_.add(Kind::TypeMismatch, span, fmt::format("{} needs numbers, and these are {}", where, type_name(*common)));
            if (*common == Type::Node) d.help = "node2int(X) gives a catom's number";
            if (common->kind == Type::Kind::List || *common == Type::String) {
                d.help = "`++` joins lists and strings";
                if (op == Op::Add && left.text != nullptr)
                    d.fixes = {diagnostics::write(span, fmt::format("{} ++ {}", syntax::print(*left.text), right_operand(right)))};
            }
        }
    } else if (op != Op::Equal && op != Op::NotEqual && !ordered(*common)) {
        report_.add(Kind::TypeMismatch, span, fmt::format("{} needs values with an order, and {} has none", where, type_name(*common)));
    }
    return common;
}

Term Scope::binary(const syntax::Binary& b, Span span) {
    const Op op = op_of(b.op);
    if (op != Op::And && op != Op::Or) return operation(op, {b.left.get(), {}, infer(*b.left), b.left->span}, *b.right, span);
    Term term;
    term.span = span;
    term.op = op;
    term.type = Type::Bool;
    term.operands.push_back(resolve(*b.left, Type::Bool, where_of(op)));
    term.operands.push_back(resolve(*b.right, Type::Bool, where_of(op)));
    return term;
}

Term Scope::operation(Op op, Left left, const syntax::Expr& right, Span span) {
    const Type r = infer(right);
    if ((op == Op::Multiply || op == Op::Divide) && (left.type == Type::Vec3) != (r == Type::Vec3))
        return vector_product(op, std::move(left), right, r, span);
    Term term;
    term.span = span;
    term.op = op;
    const std::optional<Type> common = common_type(op, left, right, r, span);
    if (!common) return term;
    term.operands.push_back(left_operand(std::move(left), *common, where_of(op)));
    term.operands.push_back(resolve(right, *common, where_of(op)));
    term.type = is_comparison(op) ? Type::Bool : refined(*common, term.operands[0].type);
    return term;
}

// A vector times or by a number; the vector comes first in the term.
Term Scope::vector_product(Op op, Left left, const syntax::Expr& right, const Type& right_type, Span span) {
    Term term;
    term.span = span;
    term.op = op;
    term.type = Type::Vec3;
    if (term.op == Op::Divide && right_type == Type::Vec3) {
        auto& d = report_.add(Kind::TypeMismatch, span, fmt::format("`/` cannot divide {} by a vector", type_name(left.type)));
        d.help = "divide by norm(...), or by one of its fields";
        return term;
    }
    const std::string where = "a product with a vector";
    const bool vector_first = left.type == Type::Vec3;
    Term number = vector_first ? Term{} : left_operand(std::move(left), Type::Float, where);
    term.operands.push_back(vector_first ? left_operand(std::move(left), Type::Vec3, where) : resolve(right, Type::Vec3, where));
    term.operands.push_back(vector_first ? resolve(right, Type::Float, where) : std::move(number));
    return term;
}

Term Scope::conditional(const syntax::Conditional& c, Span span, const Type& wanted) {
    Term term;
    term.span = span;
    term.op = Op::If;
    const Type t = infer(*c.then_value), f = infer(*c.else_value);
    const std::optional<Type> common = join(t, f);
    if (!common)
        report_.add(Kind::TypeMismatch, span, "both sides of `if` must have one type").labels = {
            {c.then_value->span, "this is " + type_name(t)}, {c.else_value->span, "this is " + type_name(f)}};
    // A list takes the type required by its context if the two agree so far; a number keeps its type and is widened as a whole.
    term.type = !common ? Type::Error : common->compound() && wanted.compound() ? join(*common, wanted).value_or(*common) : *common;
    term.operands.push_back(resolve(*c.condition, Type::Bool, "`if`"));
    term.operands.push_back(resolve(*c.then_value, term.type, "`then`"));
    term.operands.push_back(resolve(*c.else_value, term.type, "`else`"));
    return term;
}

Term Scope::let(const syntax::Let& l, Span span, const Type& wanted) {
    Term term;
    term.span = span;
    term.op = Op::Let;
    Term value = resolve(*l.value, Type::Error, fmt::format("`{}`", l.variable.text));
    const auto before = variables_.find(l.variable.text);
    const std::optional<VariableId> shadowed = before == variables_.end() ? std::nullopt : std::optional(before->second);
    term.variable = variables_[l.variable.text] = fresh(l.variable.text, value.type, l.variable.span);
    Term body = resolve(*l.body, wanted.compound() ? wanted : Type::Error, "`let`");
    term.type = body.type;
    if (shadowed)
        variables_[l.variable.text] = *shadowed;
    else
        variables_.erase(l.variable.text);
    term.operands.push_back(std::move(value));
    term.operands.push_back(std::move(body));
    return term;
}

// ---- lists, structs and tuples

// A list literal is a set or an array if the context requires one.
Term Scope::list(const syntax::ListValue& l, Span span, const Type& wanted) {
    Term term;
    term.span = span;
    Type type{holds_elements(wanted) ? wanted.kind : Type::Kind::List, {Type::Error}};
    const Type found = infer_list(l);
    if (l.rest && found.kind != Type::Kind::List && holds_elements(found)) type.kind = found.kind;
    if (type.kind == Type::Kind::Set && l.rest) {
        report_.add(Kind::TypeMismatch, span, "a set has no head and no rest").help =
            "use `E in S` for its elements, and sunion([E], S) to add one";
        return term;
    }
    if (holds_elements(found)) type.parts[0] = found.parts[0];
    // The context determines the elements' type if they cannot: [] or [1, 2] of floats.
    if (holds_elements(wanted)) type.parts[0] = join(wanted.parts[0], type.parts[0]).value_or(wanted.parts[0]);
    term.type = type;
    const std::size_t errors = report_.error_count();
    // Many elements before a rest are a list to which the rest is appended, instead of a term for each.
    const bool joined = l.rest && l.elements.size() > syntax::kLongChain;
    if (!l.rest || joined) {
        term.op = Op::List;
        for (std::size_t i = 0; i < l.elements.size(); ++i)
            term.operands.push_back(resolve(*l.elements[i], type.parts[0], fmt::format("element {} of the list", i + 1)));
        for (const Term& element : term.operands) term.type.parts[0] = refined(term.type.parts[0], element.type);
        // An element with an error has been reported; that is enough about the list.
        if (report_.error_count() > errors) term.type = Type::Error;
        if (!joined || term.type == Type::Error) return term;
        Term whole;
        whole.op = Op::Append;
        whole.span = span;
        whole.type = type;
        whole.operands.push_back(std::move(term));
        whole.operands.push_back(resolve(*l.rest, type, "the rest of a list"));
        return whole;
    }
    term = resolve(*l.rest, type, "the rest of a list");
    for (std::size_t i = l.elements.size(); i-- > 0;) {
        Term cons;
        cons.op = Op::Cons;
        cons.span = span;
        cons.type = type;
        cons.operands.push_back(resolve(*l.elements[i], type.parts[0], fmt::format("element {} of the list", i + 1)));
        cons.operands.push_back(std::move(term));
        term = std::move(cons);
    }
    return term;
}

Term Scope::fields(const std::vector<syntax::ExprPtr>& values, Type::Kind kind, Span span, const Type& wanted) {
    Term term;
    term.span = span;
    term.op = kind == Type::Kind::Struct ? Op::Struct : Op::Tuple;
    const bool guided = wanted.kind == kind && wanted.parts.size() == values.size();
    term.type = Type{kind};
    for (std::size_t i = 0; i < values.size(); ++i) {
        term.operands.push_back(resolve(*values[i], guided ? wanted.parts[i] : Type::Error, fmt::format("field {}", i + 1)));
        term.type.parts.push_back(guided ? refined(wanted.parts[i], term.operands.back().type) : term.operands.back().type);
    }
    return term;
}

// ---- names

Term Scope::constant_name(const syntax::Call& call, Span span) {
    Term term;
    term.span = span;
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
    if (std::string fact = fact_form_help(program_, call.name); !fact.empty())
        d.help = std::move(fact);
    else if (near.empty())
        d.help = fmt::format("declare it with `const {} = ...`, or write the variable `{}` with a capital", call.name, upper);
    else
        d.did_you_mean(near, span, diagnostics::Edit::Fit::Name);
    if (variables_.contains(upper)) d.fixes.push_back(diagnostics::write(span, upper, diagnostics::Edit::Fit::Name));
    return term;
}

// A run argument is a constant that the run must give; its type is the one that the context requires.
Term Scope::run_argument(int number, Span span, const Type& wanted) {
    Term term;
    term.op = Op::Constant;
    term.span = span;
    const std::string name = fmt::format("arg{}", number);
    for (const ConstantId id : program_.constants.ids())
        if (program_.constants[id].argument && program_.constants[id].name == name) term.constant = id;
    if (!term.constant.valid()) {
        Constant c;
        c.name = name;
        c.span = span;
        c.argument = true;
        term.constant = program_.constants.add(c);
    }
    Constant& constant = program_.constants[term.constant];
    if (same(constant.type, wanted)) {
        if (has_unknown(constant.type) && !has_unknown(wanted)) constant.span = span;
        constant.type = refined(constant.type, wanted);
        term.type = constant.type;
        return term;
    }
    auto& d = report_.add(Kind::TypeMismatch, span,
                          fmt::format("`@{}` is {} in one place and {} in another", name, type_name(constant.type), type_name(wanted)));
    d.labels.push_back({constant.span, fmt::format("it is {} here", type_name(constant.type))});
    d.help = "give the run two arguments, or convert it by hand";
    return term;
}

}  // namespace meld::check
