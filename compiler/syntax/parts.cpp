// The actions of the grammar: expressions, and parts that become clauses of a body or items of a head.
#include "compiler/syntax/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "compiler/syntax/item_parser.h"
#include "compiler/syntax/operators.h"
#include "compiler/syntax/syntax_error.h"
#include "runtime/base/assert.h"

namespace meld::syntax {

using diagnostics::Kind;

namespace {

constexpr std::string_view kExtreme = "00";

// 2^63 is written with this many digits.
constexpr std::uint32_t kMinimumDigits = 19;

template <class... Cases>
struct Overload : Cases... {
    using Cases::operator()...;
};
template <class... Cases>
Overload(Cases...) -> Overload<Cases...>;

const Call* bare_name(const ExprPtr& expr) {
    const Call* call = std::get_if<Call>(&expr->node);
    return call != nullptr && !call->parentheses ? call : nullptr;
}

// proved(..., p)
bool is_proved(const Call& call) {
    return call.parentheses && call.name == "proved" && call.arguments.size() == 2 && bare_name(call.arguments[1]) != nullptr;
}

// X = e in a head gives X its value for the heads behind it.
std::optional<HeadLet> head_let(Expr& expr) {
    auto* equation = std::get_if<Binary>(&expr.node);
    if (equation == nullptr || equation->op != BinaryOp::Equal) return std::nullopt;
    const auto* variable = std::get_if<Variable>(&equation->left->node);
    if (variable == nullptr) return std::nullopt;
    return HeadLet{{variable->name, equation->left->span}, std::move(equation->right)};
}

// Whether a section contains what is allowed before the first bar: names of variables.
bool are_variables(const std::vector<Part>& parts) {
    return std::all_of(parts.begin(), parts.end(), [](const Part& part) {
        const auto* value = std::get_if<ExprPtr>(&part.node);
        return value != nullptr && (std::holds_alternative<Variable>((*value)->node) || std::holds_alternative<Anonymous>((*value)->node) ||
                                    bare_name(*value) != nullptr);
    });
}

// A comprehension or aggregate without its part of variables, as Linear Meld allowed, gets an empty one.
void add_variables(std::vector<std::vector<Part>>& sections, std::size_t most) {
    MELD_EXPECT(!sections.empty(), "no section of {}", most);
    if (sections.size() < most && !are_variables(sections.front())) sections.insert(sections.begin(), std::vector<Part>{});
}

}  // namespace

Atom with_sigil(Atom atom, Sigil sigil, Span span) {
    atom.sigil = sigil;
    atom.span = span;
    return atom;
}

diagnostics::Diagnostic& Builder::wrong(Span span, std::string message, std::string help) {
    auto& diagnostic = report_.add(Kind::SyntaxError, span, std::move(message));
    diagnostic.help = std::move(help);
    return diagnostic;
}

std::optional<Item> Builder::finish(diagnostics::Reporter& report) {
    for (const std::uint32_t begin : lone_minimums_) {
        const Span span{file_index_, begin, begin + kMinimumDigits};
        report_.add(Kind::NumberOutOfRange, span, "this number does not fit").help = "the largest int is 9223372036854775807";
    }
    std::optional<Item> result;
    if (!report_.has_errors()) result = std::exchange(item_, std::nullopt);
    for (diagnostics::Diagnostic& found : report_.sorted()) {
        report.add(std::move(found));
    }
    discard();
    return result;
}

void Builder::discard() {
    report_ = {};
    item_.reset();
    lone_minimums_.clear();
}

ExprPtr Builder::literal(const Token& token) {
    const bool minimum = token.kind == TokenKind::Int && token.integer == std::numeric_limits<std::int64_t>::min();
    if (minimum) lone_minimums_.insert(token.span.begin);
    switch (token.kind) {
        case TokenKind::Int:
            return expr(IntLiteral{token.integer}, token.span);
        case TokenKind::Float:
            return expr(FloatLiteral{token.real}, token.span);
        case TokenKind::String:
            return expr(StringLiteral{token.text}, token.span);
        case TokenKind::Catom:
            return expr(CatomLiteral{token.integer}, token.span);
        case TokenKind::RunArgument:
            return expr(RunArgument{static_cast<int>(token.integer)}, token.span);
        case TokenKind::World:
            return expr(WorldSize{}, token.span);
        default:
            return expr(Anonymous{}, token.span);
    }
}

ExprPtr Builder::name(const Token& token) const {
    if (token.text == "true" || token.text == "false") return expr(BoolLiteral{token.text == "true"}, token.span);
    if (token.text == "nil") return expr(ListValue{}, token.span);
    return expr(Call{token.text, {}, false}, token.span);
}

// Of Linear Meld's machine: @cpus and @threads, the number of its threads; @thread and @host, the thread and the node that run the rule.
ExprPtr Builder::at_name(const Token& token) {
    if (token.text != "@cpus" && token.text != "@threads" && token.text != "@thread" && token.text != "@host")
        wrong(token.span, fmt::format("`{}` means nothing here", token.text), kBehindAt);
    return expr(Call{token.text, {}, true}, token.span);
}

ExprPtr Builder::call(Atom atom) const { return expr(Call{std::move(atom.name.text), std::move(atom.arguments), true}, atom.span); }

// +00 and -00, which the thesis on Linear Meld writes for numbers that no other exceeds.
ExprPtr Builder::positive(const Token& number, Span span) {
    if (number.text != kExtreme)
        wrong(span, "a number has no `+` before it", fmt::format("write `{}`", number.text)).fixes = {
            safe(diagnostics::write(span, number.text))};
    return expr(Call{fmt::format("+{}", kExtreme), {}, true}, span);
}

// A minus and the digits after it are one number: -3 is the literal, so the smallest int can be written.
ExprPtr Builder::negate(ExprPtr operand, Span span) {
    MELD_EXPECT(operand != nullptr, "a minus before nothing at {}", span.begin);
    const char first = operand->span.begin < file_.text().size() ? file_.text()[operand->span.begin] : ' ';
    const bool digits = first >= '0' && first <= '9';
    if (auto* literal = std::get_if<IntLiteral>(&operand->node); literal != nullptr && digits) {
        const Span written = operand->span;
        if (file_.text().substr(written.begin, written.end - written.begin) == kExtreme)
            return expr(Call{fmt::format("-{}", kExtreme), {}, true}, span);
        // 2^63 is stored as the smallest int already.
        lone_minimums_.erase(operand->span.begin);
        if (literal->value != std::numeric_limits<std::int64_t>::min()) literal->value = -literal->value;
        operand->span = span;
        return operand;
    }
    if (auto* literal = std::get_if<FloatLiteral>(&operand->node); literal != nullptr && digits) {
        literal->value = -literal->value;
        operand->span = span;
        return operand;
    }
    return expr(Unary{UnaryOp::Negate, std::move(operand)}, span);
}

ExprPtr Builder::binary(BinaryOp op, ExprPtr left, ExprPtr right, Span span) const {
    return chained(op, std::move(left), std::move(right), span);
}

ExprPtr Builder::cons(ExprPtr first, ExprPtr rest, Span span) const { return chained_list(std::move(first), std::move(rest), span); }

ExprPtr Builder::paren_or_tuple(std::vector<ExprPtr> fields, Span span) const {
    MELD_EXPECT(!fields.empty(), "brackets around nothing at {}", span.begin);
    if (fields.size() > 1) return expr(TupleValue{std::move(fields)}, span);
    return std::move(fields.front());
}

Delay Builder::delay(const Token& token) const {
    const Delay::Unit unit = token.text == "s" ? Delay::Unit::Seconds : token.text == "ms" ? Delay::Unit::Milliseconds : Delay::Unit::Ticks;
    return {token.real, unit, token.span};
}

// ---- clauses

std::vector<Clause> Builder::clauses(std::vector<Part> parts) {
    std::vector<Clause> result;
    result.reserve(parts.size());
    for (Part& part : parts) {
        if (auto* condition = std::get_if<ExprPtr>(&part.node)) count_proved(*condition, result);
        result.push_back(clause(std::move(part)));
    }
    return result;
}

// In proved(A, p) > 3 the count becomes a variable that a separate clause binds.
void Builder::count_proved(ExprPtr& condition, std::vector<Clause>& out) {
    auto* comparison = std::get_if<Binary>(&condition->node);
    if (comparison == nullptr) return;
    for (ExprPtr* side : {&comparison->left, &comparison->right}) {
        auto* call = std::get_if<Call>(&(*side)->node);
        if (call == nullptr || !is_proved(*call)) continue;
        const Span span = (*side)->span;
        const std::string name = fmt::format("_proved{}", ++proved_);
        Name predicate{bare_name(call->arguments[1])->name, call->arguments[1]->span};
        Proved count{expr(Variable{name}, span), std::move(predicate), std::move(call->arguments[0])};
        out.push_back(Clause{std::move(count), span});
        *side = expr(Variable{name}, span);
    }
}

Clause Builder::clause(Part part) {
    const Span span = part.span;
    if (part.delay) wrong(part.delay->span, "a body cannot wait", "a delay comes after a fact of the head: the fact arrives later");
    const auto only_in_heads = [&](std::string_view what, std::string_view help) {
        wrong(span, fmt::format("{} belongs in a head, not in a body", what), std::string(help));
        return Clause{Constraint{expr(BoolLiteral{true}, span)}, span};
    };
    return std::visit(
        Overload{
            [&](ExprPtr& condition) {
                auto* call = std::get_if<Call>(&condition->node);
                if (call == nullptr || !call->parentheses) return Clause{Constraint{std::move(condition)}, span};
                if (is_proved(*call)) {
                    Name predicate{bare_name(call->arguments[1])->name, call->arguments[1]->span};
                    return Clause{Proved{std::move(call->arguments[0]), std::move(predicate), nullptr}, span};
                }
                const auto name_end = condition->span.begin + static_cast<std::uint32_t>(call->name.size());
                Name name{call->name, {condition->span.file, condition->span.begin, name_end}};
                return Clause{Atom{Sigil::None, std::move(name), std::move(call->arguments), condition->span}, span};
            },
            [&](Comprehension&) { return only_in_heads("a comprehension", "to count or sum what matches, write S = sum X : { p(A, X) }"); },
            [&](Bracketed&) {
                return only_in_heads("a selection or rule aggregate",
                                     "[desc => X | body] is the whole left side of -o; [sum => S | X | body | head] belongs in its head");
            },
            [&](Exists&) { return only_in_heads("`exists`", "a variable that occurs only in a body exists already"); },
            [&](HeadIf&) { return only_in_heads("`if` with heads", "write one rule for each case"); },
            [&](auto& node) { return Clause{std::move(node), span}; },
        },
        part.node);
}

// `~ X in L` tests that X is not an element.
Part Builder::element(ExprPtr value, ExprPtr list, Span span) const {
    MELD_EXPECT(value != nullptr && list != nullptr, "`in` without an operand at {}", span.begin);
    auto* negated = std::get_if<Unary>(&value->node);
    if (negated == nullptr || negated->op != UnaryOp::Not || file_.text()[value->span.begin] != '~')
        return Part{Element{std::move(value), std::move(list)}, {}, span};
    Not none;
    none.clauses.push_back(Clause{Element{std::move(negated->operand), std::move(list)}, span});
    return Part{std::move(none), {}, span};
}

BodyAggregate Builder::body_aggregate(ExprPtr result, const Token& op, ExprPtr parameter, ExprPtr value, std::vector<Clause> body) {
    MELD_EXPECT(result != nullptr, "{} without a result", op.text);
    const auto* variable = std::get_if<Variable>(&result->node);
    if (variable == nullptr) wrong(result->span, "the result of an aggregate is a variable", fmt::format("S = {} X : {{ ... }}", op.text));
    if (value == nullptr && op.text != "count") {
        wrong(op.span, fmt::format("`{}` needs something to work on", op.text), fmt::format("S = {} X : {{ p(A, X) }}", op.text));
    }
    return {{variable == nullptr ? "_" : variable->name, result->span}, op.text, std::move(parameter), std::move(value), std::move(body)};
}

HeadAggregate Builder::sized_aggregate(Atom call, const Token& result) {
    if (call.arguments.size() != 1)
        wrong(call.span, fmt::format("an aggregate has one number in its brackets, and here are {}", call.arguments.size()),
              fmt::format("[{}(3) => L | X | body | head]", call.name.text));
    ExprPtr parameter = call.arguments.empty() ? nullptr : std::move(call.arguments.front());
    return {std::move(call.name.text), "", std::move(parameter), to_name(result)};
}

// ---- heads

std::vector<HeadItem> Builder::heads(std::vector<Part> parts) {
    std::vector<HeadItem> result;
    result.reserve(parts.size());
    for (Part& part : parts) result.push_back(head(std::move(part)));
    return result;
}

HeadItem Builder::head(Part part) {
    HeadItem item{Nothing{}, part.span};
    const auto only_in_bodies = [&](std::string_view what, std::string_view help) {
        wrong(item.span, fmt::format("{} belongs in a body, not in a head", what), std::string(help));
    };
    const bool is_fact = std::holds_alternative<Atom>(part.node) || std::holds_alternative<ExprPtr>(part.node);
    if (part.delay && !is_fact) wrong(part.delay->span, "only a fact can be delayed");
    std::visit(
        Overload{
            [&](ExprPtr& value) {
                auto* call = std::get_if<Call>(&value->node);
                if (std::optional<HeadLet> let = head_let(*value)) {
                    item.node = std::move(*let);
                    return;
                }
                const auto* one = std::get_if<IntLiteral>(&value->node);
                if (one != nullptr && one->value == 1) return;
                if (call == nullptr) {
                    // p(A) <- q(A) reads as a comparison with -q(A).
                    const auto* less = std::get_if<Binary>(&value->node);
                    const auto* minus = less == nullptr ? nullptr : std::get_if<Unary>(&less->right->node);
                    if (less != nullptr && less->op == BinaryOp::Less && minus != nullptr && minus->op == UnaryOp::Negate &&
                        file_.text()[less->right->span.begin - 1] == '<') {
                        const Span arrow{value->span.file, less->right->span.begin - 1, less->right->span.begin + 1};
                        wrong(arrow, "`<-` is no arrow of Meld", "write `:-`").fixes = {safe(diagnostics::write(arrow, ":-"))};
                        return;
                    }
                    wrong(value->span, "a head is made of facts, and this is not one",
                          "a head is p(A, ...), { X | body | head }, [sum => S | X | body | head], exists X. (head), or 1 for nothing;\n"
                          "write conditions in the body");
                    return;
                }
                const auto name_end = value->span.begin + static_cast<std::uint32_t>(call->name.size());
                Name name{call->name, {value->span.file, value->span.begin, name_end}};
                item.node = HeadFact{{Sigil::None, std::move(name), std::move(call->arguments), value->span}, std::move(part.delay)};
            },
            [&](Atom& atom) { item.node = HeadFact{std::move(atom), std::move(part.delay)}; },
            [&](Comprehension& node) { item.node = std::move(node); },
            [&](Exists& node) { item.node = std::move(node); },
            [&](HeadIf& node) { item.node = std::move(node); },
            [&](Bracketed& node) { bracketed_head(std::move(node), item); },
            [&](Not&) { only_in_bodies("`not`", "a head says only what holds"); },
            [&](Forall&) { only_in_bodies("`forall`", "to derive for all matches, write { X | body | head }"); },
            [&](Element&) { only_in_bodies("`in`", "put it on the other side of the arrow, or write { X | X in List | head }"); },
            [&](Delta&) { only_in_bodies("`delta`", ""); },
            [&](BodyAggregate&) { only_in_bodies("an aggregate over `{ ... }`", "in a head write [sum => S | X | body | head]"); },
        },
        part.node);
    return item;
}

std::vector<Name> Builder::variables(std::vector<Part> parts) {
    std::vector<Name> result;
    for (const Part& part : parts) {
        const auto* value = std::get_if<ExprPtr>(&part.node);
        const auto* variable = value == nullptr ? nullptr : std::get_if<Variable>(&(*value)->node);
        const Call* lower_case = value == nullptr ? nullptr : bare_name(*value);
        if (variable != nullptr) {
            result.push_back({variable->name, part.span});
        } else if (lower_case != nullptr) {
            result.push_back({lower_case->name, part.span});
        } else {
            wrong(part.span, "only variables come before the first `|`", "{ X, Y | body | head }, or { | body | head } without any");
        }
    }
    return result;
}

Comprehension Builder::comprehension(std::vector<std::vector<Part>> sections, Span span) {
    const std::size_t given = sections.size();
    add_variables(sections, 3);
    if (sections.size() != 3) {
        wrong(span, fmt::format("a comprehension has three parts, this has {}", given),
              "{ X, Y | body | head }, with nothing before the first `|` if it has no variables");
        return {};
    }
    return {variables(std::move(sections[0])), clauses(std::move(sections[1])), heads(std::move(sections[2]))};
}

// Three sections: variables, body, head with the results. Four: a head for each match before it.
void Builder::bracketed_head(Bracketed bracketed, HeadItem& item) {
    auto& sections = bracketed.sections;
    const std::size_t given = sections.size();
    add_variables(sections, 4);
    if (sections.size() != 3 && sections.size() != 4) {
        wrong(item.span, fmt::format("a rule aggregate has three or four parts after its results, this has {}", given),
              "[sum => S | X | body | head] or [sum => S | X | body | head for each | head]");
        return;
    }
    RuleAggregate aggregate;
    aggregate.aggregates = std::move(bracketed.selections);
    aggregate.variables = variables(std::move(sections[0]));
    aggregate.body = clauses(std::move(sections[1]));
    if (sections.size() == 4) aggregate.each = heads(std::move(sections[2]));
    aggregate.result = heads(std::move(sections.back()));
    item.node = std::move(aggregate);
}

// ---- rules

std::optional<Selector> Builder::selector(const Bracketed& bracketed, Span span) {
    MELD_EXPECT(!bracketed.selections.empty(), "brackets that select nothing at {}", span.begin);
    const HeadAggregate& first = bracketed.selections.front();
    const bool single = bracketed.selections.size() == 1 && first.function.empty();
    if (single && first.op == "asc") return Selector{Selector::Order::Ascending, first.result};
    if (single && first.op == "desc") return Selector{Selector::Order::Descending, first.result};
    if (single && first.op == "random") return Selector{Selector::Order::Random, first.result};
    if (single && first.op == "min") return Selector{Selector::Order::Minimum, first.result};
    wrong(span, fmt::format("`{}` selects nothing", first.op),
          "before a body comes one of [asc => X | body], [desc => X | body], [random => X | body], [min => X | body]");
    return std::nullopt;
}

void Builder::rule(Arrow arrow, std::vector<Part> body, std::vector<Part> head_parts, Span span) {
    Rule rule;
    rule.arrow = arrow;
    rule.span = span;
    auto* bracketed = body.size() == 1 ? std::get_if<Bracketed>(&body.front().node) : nullptr;
    if (bracketed != nullptr && bracketed->sections.size() == 1) {
        rule.selector = selector(*bracketed, body.front().span);
        std::vector<Part> selected = std::move(bracketed->sections.front());
        body = std::move(selected);
    }
    rule.body = clauses(std::move(body));
    rule.head = heads(std::move(head_parts));
    // `p(A) -o .` consumes and produces nothing.
    if (rule.head.empty()) rule.head.push_back({Nothing{}, {span.file, span.end, span.end}});
    item(std::move(rule));
}

}  // namespace meld::syntax
