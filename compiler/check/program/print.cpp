// The checked program as text.
#include <fmt/format.h>

#include <algorithm>

#include "compiler/check/program/forall.h"
#include "compiler/check/program/operators.h"
#include "compiler/check/program/program.h"
#include "compiler/syntax/stable_name.h"

namespace meld::check {

std::string type_name(const Type& type) {
    const auto joined = [&] {
        std::string text;
        for (const Type& part : type.parts) text += (text.empty() ? "" : ", ") + type_name(part);
        return text;
    };
    switch (type.kind) {
        case Type::Kind::Error:
            return "_";
        case Type::Kind::Int:
            return "int";
        case Type::Kind::Float:
            return "float";
        case Type::Kind::Bool:
            return "bool";
        case Type::Kind::Node:
            return "node";
        case Type::Kind::String:
            return "string";
        case Type::Kind::List:
            return "list " + joined();
        case Type::Kind::Set:
            return "set " + joined();
        case Type::Kind::Array:
            return "array " + joined();
        case Type::Kind::Struct:
            return ":(" + joined() + ")";
        case Type::Kind::Tuple:
            return "(" + joined() + ")";
        case Type::Kind::Vec3:
            return "vec3";
    }
    return "";
}

bool is_forall(const Clause& clause) {
    if (clause.kind != Clause::Kind::Not || clause.inner.empty()) return false;
    const Clause& last = clause.inner.back();
    return last.kind == Clause::Kind::Not && clause.span.file == last.span.file && clause.span.begin == last.span.begin &&
           clause.span.end == last.span.end;
}

TakeApart taken_apart(const Term& test) {
    if (test.op != Op::Equal) return {};
    for (const std::size_t side : {0u, 1u}) {
        const Term& constructor = test.operands[side];
        const bool makes =
            constructor.op == Op::List || constructor.op == Op::Cons || constructor.op == Op::Struct || constructor.op == Op::Tuple;
        // A set keeps no order of elements to take apart.
        if (makes && constructor.type.kind != Type::Kind::Set && test.operands[1 - side].is_variable())
            return {&test.operands[1 - side], &constructor};
    }
    return {};
}

std::string aggregate_name(Aggregate aggregate) { return std::string(info(aggregate).word); }
std::string aggregate_name(const Program& program, const Predicate& p) {
    if (p.parameter.op != Op::Anonymous) return fmt::format("{}({})", aggregate_name(p.aggregate), print(program, Rule{}, p.parameter));
    return p.aggregate == Aggregate::Custom && p.fold.valid() ? program.functions[p.fold].name : aggregate_name(p.aggregate);
}

namespace {

const char* function_name(Op op) {
    switch (op) {
        case Op::ToFloat:
            return "float";
        case Op::Min:
            return "min";
        case Op::Max:
            return "max";
        case Op::Abs:
            return "abs";
        case Op::Truncate:
            return "truncate";
        case Op::Sqrt:
            return "sqrt";
        case Op::NodeToInt:
            return "node2int";
        case Op::ListHead:
            return "head";
        case Op::ListTail:
            return "tail";
        case Op::IsEmpty:
            return "empty";
        case Op::Ticks:
            return "ticks";
        case Op::Due:
            return "due";
        case Op::NextHop:
            return "next_hop";
        default:
            return nullptr;
    }
}

std::string joined(const Program& program, const Rule& rule, const std::vector<Clause>& body) {
    std::string text;
    for (const Clause& c : body) text += (text.empty() ? "" : ", ") + print(program, rule, c);
    return text;
}

std::string joined_operands(const Program& program, const Rule& rule, const Term& t) {
    std::string text;
    for (const Term& operand : t.operands) text += (text.empty() ? "" : ", ") + print(program, rule, operand);
    return text;
}

// A term of a function.
std::string print_in(const Program& program, const Function& f, const Term& t) {
    Rule makeshift;
    makeshift.variables = f.variables;
    return print(program, makeshift, t);
}

std::string print_function(const Program& program, const Function& f) {
    std::string text = f.external ? fmt::format("extern {} {}(", type_name(f.result), f.name) : fmt::format("fun {}(", f.name);
    for (std::size_t i = 0; i < f.parameter_count; ++i) {
        const Variable& v = f.variables[VariableId(i)];
        text += (i ? ", " : "") + type_name(v.type) + (f.external ? "" : " " + v.name);
    }
    return text + (f.external ? ").\n" : fmt::format(") : {} = {}.\n", type_name(f.result), print_in(program, f, f.body)));
}

std::string print_constant(const Program& program, const Constant& c) {
    if (c.argument) return fmt::format("// @{} is {}\n", c.name, type_name(c.type));
    if (c.computed.valid())
        return fmt::format("const {} = {}.  // {}, computed where it is used\n", c.name,
                           print_in(program, program.functions[c.computed], program.functions[c.computed].body), type_name(c.type));
    const std::string value = c.type.compound() && c.type != Type::String ? print(program, Rule{}, c.value)
                              : c.type == Type::String                    ? fmt::format("\"{}\"", c.text)
                              : c.type == Type::Float                     ? fmt::format("{:#}", c.real)
                                                                          : std::to_string(c.integer);
    return fmt::format("const {} = {}.  // {}\n", c.name, value, type_name(c.type));
}

std::string print_heads(const Program& program, const Rule& rule, const std::vector<Head>& heads);

// The (3) of min_k(3).
std::string parameter(const Program& program, const Rule& rule, const Term& number) {
    return number.op == Op::Anonymous ? "" : "(" + print(program, rule, number) + ")";
}

// sum X => S
std::string print_aggregate(const Program& program, const Rule& rule, const HeadAggregate& one) {
    std::string text = aggregate_name(one.aggregate);
    if (one.aggregate == Aggregate::Custom) text = program.functions[one.function].name;
    if (one.aggregate != Aggregate::Custom)
        text += parameter(program, rule, one.parameter);
    else if (one.parameter.op != Op::Anonymous)
        text += " from " + print(program, rule, one.parameter);
    if (one.each.valid()) text += " " + rule.variables[one.each].name;
    return text + " => " + rule.variables[one.result].name;
}

std::string print_head(const Program& program, const Rule& rule, const Head& head) {
    const std::string heads = print_heads(program, rule, head.heads), others = print_heads(program, rule, head.others);
    switch (head.kind) {
        case Head::Kind::Fact:
            return print(program, rule, head.atom) + (head.delay.op == Op::Anonymous ? "" : "@+" + print(program, rule, head.delay));
        case Head::Kind::Comprehension:
            return fmt::format("{{ | {} | {} }}", joined(program, rule, head.body), heads);
        case Head::Kind::Aggregate: {
            std::string aggregates;
            for (const HeadAggregate& f : head.aggregates)
                aggregates += (aggregates.empty() ? "" : ", ") + print_aggregate(program, rule, f);
            return fmt::format("[ {} | {} | {} | {} ]", aggregates, joined(program, rule, head.body), heads, others);
        }
        case Head::Kind::If:
            return fmt::format("(if {} then {} otherwise {} end)", print(program, rule, head.term), heads, others);
        case Head::Kind::Set:
            return fmt::format("{} = {} in ({})", rule.variables[head.variable].name, print(program, rule, head.term), heads);
    }
    return "";
}

std::string print_heads(const Program& program, const Rule& rule, const std::vector<Head>& heads) {
    std::string text;
    for (const Head& h : heads) text += (text.empty() ? "" : ", ") + print_head(program, rule, h);
    return text.empty() ? "1" : text;
}

std::string print_declaration(const Program& program, const Predicate& p) {
    std::string text = "type ";
    if (p.route) text += "route ";
    if (p.linear()) text += "linear ";
    if (p.sensed) text += "sensed ";
    if (p.kind == PredicateKind::Action) text += "action ";
    text += p.name + "(";
    for (std::size_t i = 0; i < p.arguments.size(); ++i) {
        text += i ? ", " : "";
        if (p.aggregate != Aggregate::None && p.aggregate_at == i) text += aggregate_name(program, p) + " ";
        text += type_name(p.arguments[i].type);
        if (p.complete_link.valid() && p.aggregate_at == i)
            text += fmt::format(" [{} {}]", p.complete_outgoing ? "->" : "<-", program.predicates[p.complete_link].name);
        if (!p.arguments[i].name.empty()) text += " " + p.arguments[i].name;
    }
    return text + (p.repeats ? ") while." : ").");
}

}  // namespace

std::string print(const Program& program, const Rule& rule, const Term& t) {
    const auto operand = [&](std::size_t i) { return print(program, rule, t.operands[i]); };
    switch (t.op) {
        case Op::Variable:
            return rule.variables[t.variable].name;
        case Op::Anonymous:
            return "_";
        case Op::Int:
            return std::to_string(t.integer);
        case Op::Float:
            return fmt::format("{:#}", t.real);
        case Op::Bool:
            return t.integer ? "true" : "false";
        case Op::Node:
            return fmt::format("@{}", t.integer);
        case Op::String:
            return fmt::format("\"{}\"", t.text);
        case Op::Constant:
            return program.constants[t.constant].name;
        case Op::Negate:
            return "-" + operand(0);
        case Op::Not:
            return "~" + operand(0);
        case Op::WorldSize:
            return "@world";
        case Op::List:
            return "[" + joined_operands(program, rule, t) + "]";
        case Op::Cons:
            return fmt::format("[{} | {}]", operand(0), operand(1));
        case Op::Struct:
            return ":(" + joined_operands(program, rule, t) + ")";
        case Op::Tuple:
            return (t.type == Type::Vec3 ? "vec3(" : "(") + joined_operands(program, rule, t) + ")";
        case Op::Item:
            return fmt::format("field({}, {})", operand(0), t.integer);
        case Op::Let:
            return fmt::format("let {} = {} in {} end", rule.variables[t.variable].name, operand(0), operand(1));
        case Op::Call:
            return program.functions[t.function].name + "(" + joined_operands(program, rule, t) + ")";
        case Op::Library:
            return t.text + "(" + joined_operands(program, rule, t) + ")";
        case Op::Now:
            return "now";
        case Op::Fresh:
            return "new";
        case Op::NewNode:
            return "new node";
        case Op::If:
            return fmt::format("if {} then {} else {} end", operand(0), operand(1), operand(2));
        default:
            break;
    }
    if (const std::string_view sign = sign_of(t.op); !sign.empty()) {
        const auto side = [&](std::size_t i) { return sign_of(t.operands[i].op).empty() ? operand(i) : "(" + operand(i) + ")"; };
        return fmt::format("{} {} {}", side(0), sign, side(1));
    }
    return std::string(function_name(t.op)) + "(" + joined_operands(program, rule, t) + ")";
}

std::string print(const Program& program, const Rule& rule, const Atom& atom) {
    std::string arguments;
    for (std::size_t i = 0; i < atom.arguments.size(); ++i) arguments += (i ? ", " : "") + print(program, rule, atom.arguments[i]);
    return (atom.read_only ? "$" : "") + syntax::print_fact(program.predicates[atom.predicate].name, arguments);
}

std::string print(const Program& program, const Rule& rule, const Clause& clause) {
    switch (clause.kind) {
        case Clause::Kind::Atom:
            return print(program, rule, clause.atom);
        case Clause::Kind::Test:
            return print(program, rule, clause.test);
        case Clause::Kind::Not:
            return "not (" + joined(program, rule, clause.inner) + ")";
        case Clause::Kind::Element:
            return rule.variables[clause.variable].name + " in " + print(program, rule, clause.test);
        case Clause::Kind::Aggregate: {
            const std::string name =
                clause.aggregate == Aggregate::Custom ? program.functions[clause.fold].name : aggregate_name(clause.aggregate);
            const std::string value = clause.test.op == Op::Anonymous ? "" : " " + print(program, rule, clause.test);
            const std::string number = clause.aggregate == Aggregate::Custom ? "" : parameter(program, rule, clause.parameter);
            return fmt::format("{} = {}{}{} : {{ {} }}", rule.variables[clause.variable].name, name, number, value,
                               joined(program, rule, clause.inner));
        }
        case Clause::Kind::Delta:
            return fmt::format("delta({}; {}) {} {}", rule.variables[clause.variable].name, print(program, rule, clause.atom),
                               sign_of(clause.compare), print(program, rule, clause.test));
    }
    return "";
}

std::string print(const Program& program, const Rule& rule) {
    const std::string heads = print_heads(program, rule, rule.heads);
    std::string body = joined(program, rule, rule.body);
    if (body.empty()) return heads + ".";
    if (rule.select != Select::None)
        body = fmt::format("[{} => {} | {}]",
                           rule.select == Select::Random      ? "random"
                           : rule.select == Select::Ascending ? "asc"
                                                              : "desc",
                           rule.variables[rule.selected].name, body);
    return rule.linear ? body + " -o " + heads + "." : heads + " :- " + body + ".";
}

std::string print(const Program& program) {
    std::string text;
    for (const Predicate& p : program.predicates)
        if (!p.prelude) text += print_declaration(program, p) + "\n";
    for (const Constant& c : program.constants)
        if (!c.prelude) text += print_constant(program, c);
    for (const FunctionId id : program.functions.ids()) {
        const bool constant =
            std::any_of(program.constants.begin(), program.constants.end(), [&](const Constant& c) { return c.computed == id; });
        if (!constant && !program.functions[id].of_library) text += print_function(program, program.functions[id]);
    }
    for (const Rule& rule : program.rules) {
        text += fmt::format("\n// {}, runs at {}", rule.name, rule.site.valid() ? rule.variables[rule.site].name : "?");
        for (const Variable& v : rule.variables) text += fmt::format(", {}: {}", v.name, type_name(v.type));
        text += "\n" + print(program, rule) + "\n";
    }
    text += "\n// Strata in the order of evaluation\n";
    for (const Stratum& c : program.strata) {
        if (c.rules.empty()) continue;
        text += "//  ";
        for (const PredicateId p : c.predicates) text += " " + program.predicates[p].name;
        if (c.recursive)
            text += fmt::format(": recursive{}{}{}", c.local ? ", at the catom" : "", c.links ? ", over links" : "",
                                c.tree ? ", sums over a tree" : "");
        text += "\n";
    }
    return text;
}

}  // namespace meld::check
