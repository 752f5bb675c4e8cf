// Pass: constant folding. A variable that equals a literal becomes the literal, operators on literals become their value, and true tests
// disappear. Constants of the program stay: a run may give them other values. An operation that would stop the run (overflow, division by
// zero) stays in place, because only a rule that reaches it may stop the run.
#include <map>
#include <optional>
#include <set>

#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

bool is_literal(const Term& t) { return t.op == Op::Int || t.op == Op::Bool; }

std::optional<std::int64_t> value_of(Op op, std::int64_t a, std::int64_t b) {
    std::int64_t r = 0;
    switch (op) {
        case Op::Add:
            return __builtin_add_overflow(a, b, &r) ? std::nullopt : std::optional(r);
        case Op::Subtract:
            return __builtin_sub_overflow(a, b, &r) ? std::nullopt : std::optional(r);
        case Op::Multiply:
            return __builtin_mul_overflow(a, b, &r) ? std::nullopt : std::optional(r);
        case Op::Divide:
            return b == 0 || b == -1 ? std::nullopt : std::optional(a / b);
        case Op::Modulo:
            return b == 0 ? std::nullopt : std::optional(b == -1 ? 0 : a % b);
        case Op::Min:
            return std::min(a, b);
        case Op::Max:
            return std::max(a, b);
        case Op::Equal:
            return a == b;
        case Op::NotEqual:
            return a != b;
        case Op::Less:
            return a < b;
        case Op::LessEqual:
            return a <= b;
        case Op::Greater:
            return a > b;
        case Op::GreaterEqual:
            return a >= b;
        default:
            return std::nullopt;
    }
}

void become(Term& t, std::int64_t value) {
    t.op = t.type == Type::Bool ? Op::Bool : Op::Int;
    t.integer = value;
    t.operands.clear();
}

void fold(Term& t) {
    for (Term& operand : t.operands) fold(operand);
    if (t.operands.empty() || !(t.type == Type::Int || t.type == Type::Bool)) return;
    Term& first = t.operands[0];
    const bool logic = t.op == Op::And || t.op == Op::Or;
    if (logic && is_literal(t.operands[1]) && (t.operands[1].integer != 0) == (t.op == Op::And)) {
        Term rest = std::move(first);
        t = std::move(rest);
        return;
    }
    if (!is_literal(first)) return;
    switch (t.op) {
        case Op::Not:
            return become(t, first.integer == 0);
        case Op::Negate:
            if (first.integer != INT64_MIN) become(t, -first.integer);
            return;
        // The first operand decides, or the second does: in this order they are evaluated.
        case Op::And:
        case Op::Or: {
            if ((first.integer != 0) == (t.op == Op::Or)) return become(t, t.op == Op::Or);
            Term rest = std::move(t.operands[1]);
            t = std::move(rest);
            return;
        }
        case Op::If: {
            Term chosen = std::move(t.operands[first.integer != 0 ? 1 : 2]);
            if (chosen.type == t.type)
                t = std::move(chosen);
            else
                t.operands[first.integer != 0 ? 1 : 2] = std::move(chosen);
            return;
        }
        default:
            break;
    }
    if (t.operands.size() != 2 || !is_literal(t.operands[1]) || t.operands[1].op != first.op) return;
    if (const auto value = value_of(t.op, first.integer, t.operands[1].integer)) become(t, *value);
}

class Folder {
  public:
    explicit Folder(Rule& rule) : rule_(rule) {}

    void run() {
        for (bool again = true; again;) {
            fold_body(rule_.body);
            for (Head& h : rule_.heads) fold_head(h);
            again = propagate();
        }
        std::erase_if(rule_.body,
                      [](const Clause& c) { return c.kind == Clause::Kind::Test && c.test.op == Op::Bool && c.test.integer != 0; });
    }

  private:
    static void fold_body(std::vector<Clause>& body) {
        for (Clause& c : body) {
            for (std::size_t i = 1; i < c.atom.arguments.size(); ++i) fold(c.atom.arguments[i]);
            fold(c.test);
            fold_body(c.inner);
        }
    }
    static void fold_head(Head& h) {
        for (std::size_t i = 1; i < h.atom.arguments.size(); ++i) fold(h.atom.arguments[i]);
        fold(h.delay);
        fold(h.term);
        fold_body(h.body);
        for (Head& inner : h.heads) fold_head(inner);
        for (Head& inner : h.others) fold_head(inner);
    }

    // Takes one equality of a variable with a literal out of the body. Variables of clauses and heads that bind by name
    // (elements, aggregates, selections) are left alone.
    bool propagate() {
        for (std::size_t i = 0; i < rule_.body.size(); ++i) {
            const Clause& c = rule_.body[i];
            if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) continue;
            for (const std::size_t side : {0u, 1u}) {
                const Term& target = c.test.operands[side];
                const Term value = c.test.operands[1 - side];
                if (!target.is_variable() || !is_literal(value) || !(target.type == value.type) || bound_by_name(target.variable)) continue;
                const VariableId variable = target.variable;
                rule_.body.erase(rule_.body.begin() + static_cast<std::ptrdiff_t>(i));
                for (Clause& other : rule_.body) replace(other, variable, value);
                for (Head& h : rule_.heads) replace(h, variable, value);
                return true;
            }
        }
        return false;
    }

    bool bound_by_name(VariableId v) const {
        bool found = rule_.selected == v || rule_.site == v;
        const auto body = [&](const auto& self, const std::vector<Clause>& clauses) -> void {
            for (const Clause& c : clauses) {
                found = found || c.variable == v;
                self(self, c.inner);
            }
        };
        body(body, rule_.body);
        each_head(rule_.heads, [&](const Head& h) {
            body(body, h.body);
            found = found || h.variable == v;
            for (const HeadAggregate& f : h.aggregates) found = found || f.each == v || f.result == v;
        });
        return found;
    }

    static void replace(Term& t, VariableId v, const Term& value) {
        if (t.is_variable() && t.variable == v)
            t = value;
        else
            for (Term& operand : t.operands) replace(operand, v, value);
    }
    static void replace(Clause& c, VariableId v, const Term& value) {
        for (Term& t : c.atom.arguments) replace(t, v, value);
        replace(c.test, v, value);
        for (Clause& inner : c.inner) replace(inner, v, value);
    }
    static void replace(Head& h, VariableId v, const Term& value) {
        for (Term& t : h.atom.arguments) replace(t, v, value);
        replace(h.delay, v, value);
        replace(h.term, v, value);
        for (Clause& c : h.body) replace(c, v, value);
        for (HeadAggregate& f : h.aggregates) replace(f.parameter, v, value);
        for (Head& inner : h.heads) replace(inner, v, value);
        for (Head& inner : h.others) replace(inner, v, value);
    }

    Rule& rule_;
};

}  // namespace

void fold_constants(check::Program& program) {
    for (Rule& rule : program.rules) Folder(rule).run();
}

}  // namespace meld::plan
