#include "compiler/check/names/scope.h"

#include <algorithm>
#include <tuple>

#include "runtime/base/assert.h"

namespace meld::check {

using diagnostics::Kind;
using syntax::BinaryOp;

namespace {

// Deeper nesting would need more stack than a C++ compiler has.
constexpr int kMaxNesting = 300;

}  // namespace

Names::Names(const Program& program, const syntax::Tree& source) : tree(source) {
    for (const PredicateId id : program.predicates.ids())
        predicates.emplace(std::pair(program.predicates[id].name, program.predicates[id].arguments.size()), id);
    for (const ConstantId id : program.constants.ids())
        if (!program.constants[id].argument) constants.emplace(program.constants[id].name, id);
    for (const FunctionId id : program.functions.ids())
        if (!program.functions[id].of_library) functions.emplace(program.functions[id].name, id);
}

Clause equality(Term left, Term right, Span span) {
    Clause c{.kind = Clause::Kind::Test};
    c.span = c.test.span = span;
    c.test.op = Op::Equal;
    c.test.type = Type::Bool;
    c.test.operands = {std::move(left), std::move(right)};
    return c;
}

VariableId Scope::variable(const std::string& name, Span span) {
    MELD_EXPECT(!name.empty(), "a variable without a name at {}", span.begin);
    const auto found = variables_.find(name);
    if (found != variables_.end()) return found->second;
    return variables_[name] = rule_.variables.add({name, span, Type::Error});
}

void Scope::enter(const void* part, const std::set<std::string>& names) {
    MELD_EXPECT(part != nullptr, "no part with {} names", names.size());
    Entered& now = entered_.emplace_back(Entered{part, {}, names});
    const auto& own = parts_[part];
    for (const std::string& name : names) {
        if (const auto outside = variables_.find(name); outside != variables_.end()) {
            now.hidden.insert(*outside);
            variables_.erase(outside);
        }
        if (const auto known = own.find(name); known != own.end()) variables_.insert(*known);
    }
}

void Scope::leave() {
    MELD_EXPECT(!entered_.empty(), "left more often than entered");
    const Entered last = std::move(entered_.back());
    entered_.pop_back();
    auto& own = parts_[last.part];
    for (const std::string& name : last.names)
        if (const auto used = variables_.find(name); used != variables_.end()) {
            own.insert(*used);
            variables_.erase(used);
        }
    variables_.insert(last.hidden.begin(), last.hidden.end());
}

VariableId Scope::fresh(const std::string& name, const Type& type, Span span) { return rule_.variables.add({name, span, type}); }

const std::string* Scope::variable_name(const syntax::Expr& e) const {
    if (const auto* v = std::get_if<syntax::Variable>(&e.node)) return &v->name;
    if (const auto* c = std::get_if<syntax::Call>(&e.node);
        c != nullptr && !c->parentheses && lower_case_variables_ && !names_.constants.contains(c->name) && !names_.tree.is_lost(c->name))
        return &c->name;
    return nullptr;
}

// ---- types inferred so far, without reports

Type Scope::infer(const syntax::Expr& e) const {
    if (const std::string* name = variable_name(e)) {
        for (auto let = lets_.rbegin(); let != lets_.rend(); ++let)
            if (let->first == *name) return let->second;
        const auto found = variables_.find(*name);
        return found == variables_.end() ? Type::Error : rule_.variables[found->second].type;
    }
    const auto all = [this](Type::Kind kind, const std::vector<syntax::ExprPtr>& values) {
        Type type{kind};
        for (const auto& value : values) type.parts.push_back(infer(*value));
        return type;
    };
    if (std::holds_alternative<syntax::IntLiteral>(e.node) || std::holds_alternative<syntax::WorldSize>(e.node)) return Type::Int;
    if (std::holds_alternative<syntax::FloatLiteral>(e.node)) return Type::Float;
    if (const auto* b = std::get_if<syntax::BoolLiteral>(&e.node)) {
        const auto own = names_.constants.find(b->value ? "true" : "false");
        return own == names_.constants.end() ? Type::Bool : program_.constants[own->second].type;
    }
    if (std::holds_alternative<syntax::StringLiteral>(e.node)) return Type::String;
    if (std::holds_alternative<syntax::CatomLiteral>(e.node)) return Type::Node;
    if (const auto* c = std::get_if<syntax::Call>(&e.node)) return infer_call(*c);
    if (const auto* u = std::get_if<syntax::Unary>(&e.node)) return u->op == syntax::UnaryOp::Not ? Type::Bool : infer(*u->operand);
    if (const auto* b = std::get_if<syntax::Binary>(&e.node))
        return b->op >= BinaryOp::Equal ? Type::Bool : inferred(b->op, infer(*b->left), infer(*b->right));
    if (const auto* c = std::get_if<syntax::Chain>(&e.node)) return infer_chain(*c);
    if (const auto* c = std::get_if<syntax::Conditional>(&e.node))
        return join(infer(*c->then_value), infer(*c->else_value)).value_or(Type::Error);
    if (const auto* l = std::get_if<syntax::ListValue>(&e.node)) return infer_list(*l);
    if (const auto* s = std::get_if<syntax::StructValue>(&e.node)) return all(Type::Kind::Struct, s->fields);
    if (const auto* t = std::get_if<syntax::TupleValue>(&e.node)) return all(Type::Kind::Tuple, t->fields);
    if (const auto* l = std::get_if<syntax::Let>(&e.node)) return infer_let(*l);
    if (const auto* a = std::get_if<syntax::RunArgument>(&e.node))
        for (const Constant& c : program_.constants)
            if (c.argument && c.name == fmt::format("arg{}", a->number)) return c.type;
    return Type::Error;
}

Type Scope::infer_call(const syntax::Call& c) const {
    if (!c.parentheses) {
        const auto constant = names_.constants.find(c.name);
        return constant == names_.constants.end() ? Type::Error : program_.constants[constant->second].type;
    }
    if (const auto own = names_.functions.find(c.name); own != names_.functions.end()) return program_.functions[own->second].result;
    const LibraryFunction* f = library_function(c.name, c.arguments.size());
    if (f == nullptr) return Type::Error;
    LibraryBindings bindings;
    for (std::size_t i = 0; i < f->parameters.size() && i < c.arguments.size(); ++i)
        match(f->parameters[i], infer(*c.arguments[i]), bindings);
    return substitute(f->result, bindings);
}

// A list whose elements do not go together is reported when it is resolved.
Type Scope::infer_list(const syntax::ListValue& list) const {
    Type type = list.rest ? infer(*list.rest) : Type::list_of(Type::Error);
    if (type == Type::Error) type = Type::list_of(Type::Error);
    if (type.parts.size() != 1) return Type::Error;
    for (const auto& element : list.elements) type.parts[0] = join(type.parts[0], infer(*element)).value_or(type.parts[0]);
    return type;
}

Type Scope::infer_let(const syntax::Let& l) const {
    lets_.emplace_back(l.variable.text, infer(*l.value));
    Type type = infer(*l.body);
    lets_.pop_back();
    return type;
}

Type Scope::infer_chain(const syntax::Chain& c) const {
    if (c.ops.front() >= BinaryOp::Equal) return Type::Bool;
    Type type = infer(*c.operands.front());
    for (std::size_t i = 0; i < c.ops.size(); ++i) type = inferred(c.ops[i], type, infer(*c.operands[i + 1]));
    return type;
}

Type Scope::inferred(BinaryOp op, const Type& left, const Type& right) {
    if (left == Type::Vec3 || right == Type::Vec3) return Type::Vec3;
    if (op != BinaryOp::Append && (left == Type::Error || right == Type::Error)) return Type::Error;
    return join(left, right).value_or(Type::Error);
}

// ---- terms

namespace {

// The library function that makes one type of another; empty if there is none.
std::string_view conversion(const Type& from, const Type& to) {
    using Of = Type::Kind;
    static constexpr std::tuple<Of, Of, std::string_view> kConversions[] = {
        {Of::Float, Of::Int, "truncate"},     {Of::Node, Of::Int, "node2int"},     {Of::Int, Of::String, "int2str"},
        {Of::Float, Of::String, "float2str"}, {Of::Node, Of::String, "node2str"},  {Of::String, Of::Int, "str2int"},
        {Of::String, Of::Float, "str2float"}, {Of::List, Of::Set, "list2set"},     {Of::Set, Of::List, "set2list"},
        {Of::List, Of::Array, "list2array"},  {Of::Array, Of::List, "array2list"},
    };
    for (const auto& [a, b, function] : kConversions)
        if (from.kind == a && to.kind == b && std::equal(from.parts.begin(), from.parts.end(), to.parts.begin(), to.parts.end(), same))
            return function;
    return "";
}

}  // namespace

Term Scope::convert(Term term, const Type& wanted, const std::string& where, Written written, Span declared) {
    if (wanted == Type::Error || term.type == Type::Error || term.type == wanted) return term;
    if (wanted == Type::Float && term.type == Type::Int) {
        Term wide;
        wide.op = Op::ToFloat;
        wide.type = Type::Float;
        wide.span = term.span;
        wide.operands.push_back(std::move(term));
        return wide;
    }
    if (same(term.type, wanted)) {
        term.type = refined(term.type, wanted);
        return term;
    }
    auto& d = report_.add(Kind::TypeMismatch, term.span,
                          fmt::format("{} needs {}, and this is {}", where, type_name(wanted), type_name(term.type)));
    if (declared.end > declared.begin) d.labels.push_back({declared, fmt::format("it is declared here as {}", type_name(wanted))});
    if (term.is_variable())
        d.labels.push_back({rule_.variables[term.variable].span,
                            fmt::format("`{}` is {} here", rule_.variables[term.variable].name, type_name(term.type))});
    if (term.op == Op::Call)
        d.labels.push_back({program_.functions[term.function].span,
                            fmt::format("`{}` gives {}", program_.functions[term.function].name, type_name(term.type))});
    if (term.op == Op::Constant)
        d.labels.push_back({program_.constants[term.constant].span,
                            fmt::format("`{}` is {}", program_.constants[term.constant].name, type_name(term.type))});
    if (wanted == Type::Node && term.op == Op::Int) {
        d.help = fmt::format("write @{} for the catom of this number", term.integer);
        if (written == Written::Here && term.integer >= 0) d.fixes = {diagnostics::write(term.span, fmt::format("@{}", term.integer))};
    }
    const std::string_view function = written == Written::Here ? conversion(term.type, wanted) : "";
    if (!function.empty()) d.fixes = {diagnostics::call_around(term.span, function)};
    if (wanted == Type::Int && term.type == Type::Float) d.help = "write truncate(...) to drop the fraction";
    if (wanted == Type::String && term.type == Type::Int) d.help = "write int2str(...)";
    if (wanted == Type::String && term.type == Type::Float) d.help = "write float2str(...)";
    term.type = Type::Error;
    return term;
}

Term Scope::resolve(const syntax::Expr& e, const Type& wanted, const std::string& where, bool anonymous_fits, Span declared) {
    if (std::holds_alternative<syntax::Anonymous>(e.node)) {
        Term term;
        term.span = e.span;
        term.type = wanted;
        if (!anonymous_fits) report_.add(Kind::UnboundVariable, e.span, fmt::format("`_` stands for any value, and {} needs one", where));
        return term;
    }
    if (const std::string* name = variable_name(e)) {
        Variable& v = rule_.variables[variable(*name, e.span)];
        v.type = refined(v.type, wanted);
    }
    if (depth_ >= kMaxNesting) {
        report_.add(Kind::NestingTooDeep, e.span, fmt::format("this is nested more than {} levels deep", kMaxNesting)).help =
            "give parts of it names with X = e";
        Term term;
        term.span = e.span;
        return term;
    }
    MELD_ASSERT(depth_ >= 0 && depth_ < kMaxNesting, "depth {}", depth_);
    ++depth_;
    Term term = untyped(e, wanted);
    --depth_;
    return convert(std::move(term), wanted, where, Written::Here, declared);
}

Term Scope::untyped(const syntax::Expr& e, const Type& wanted) {
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
        // A program may have constants of its own by these names.
        const char* constant = b->value ? "true" : "false";
        if (names_.constants.contains(constant)) return constant_name({constant, {}, false}, e.span);
        term.op = Op::Bool;
        term.type = Type::Bool;
        term.integer = b->value;
    } else if (const auto* s = std::get_if<syntax::StringLiteral>(&e.node)) {
        term.op = Op::String;
        term.type = Type::String;
        term.text = s->value;
    } else if (const auto* c = std::get_if<syntax::CatomLiteral>(&e.node)) {
        term.op = Op::Node;
        term.type = Type::Node;
        term.integer = c->id;
    } else if (std::holds_alternative<syntax::WorldSize>(e.node)) {
        term.op = Op::WorldSize;
        term.type = Type::Int;
    } else if (const auto* a = std::get_if<syntax::RunArgument>(&e.node)) {
        return run_argument(a->number, e.span, wanted);
    } else if (const auto* call = std::get_if<syntax::Call>(&e.node)) {
        return call->parentheses ? this->call(call->name, call->arguments, e.span, wanted) : constant_name(*call, e.span);
    } else if (const auto* u = std::get_if<syntax::Unary>(&e.node)) {
        return unary(*u, e.span);
    } else if (const auto* bin = std::get_if<syntax::Binary>(&e.node)) {
        return binary(*bin, e.span);
    } else if (const auto* row = std::get_if<syntax::Chain>(&e.node)) {
        return chain(*row, e.span);
    } else if (const auto* cond = std::get_if<syntax::Conditional>(&e.node)) {
        return conditional(*cond, e.span, wanted);
    } else if (const auto* l = std::get_if<syntax::ListValue>(&e.node)) {
        return list(*l, e.span, wanted);
    } else if (const auto* record = std::get_if<syntax::StructValue>(&e.node)) {
        return fields(record->fields, Type::Kind::Struct, e.span, wanted);
    } else if (const auto* tuple = std::get_if<syntax::TupleValue>(&e.node)) {
        return fields(tuple->fields, Type::Kind::Tuple, e.span, wanted);
    } else if (const auto* inner = std::get_if<syntax::Let>(&e.node)) {
        return let(*inner, e.span, wanted);
    } else {
        report_.add(Kind::UnboundVariable, e.span, "`_` stands for any value, and an expression needs one");
    }
    return term;
}

}  // namespace meld::check
