// Pass: constant folding. A variable that equals a literal becomes the literal, operators on literals become their value, and true tests
// disappear. Constants of the program stay: a run may give them other values. An operation that would stop the run (overflow, division by
// zero) stays in place, because only a rule that reaches it may stop the run.
#include <algorithm>
#include <optional>

#include "compiler/check/program/arithmetic.h"
#include "compiler/check/program/operators.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

bool is_literal(const Term& t) { return t.op == Op::Int || t.op == Op::Bool; }

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
    // A function of one number, or an operator between two literals of one type.
    const Term& last = t.operands.back();
    if (t.operands.size() > 2 || last.op != first.op) return;
    if (is_comparison(t.op))
        become(t, holds(t.op, first.integer, last.integer));
    else if (const auto value = compute(t.op, first.integer, last.integer).value)
        become(t, *value);
}

class Folder {
  public:
    explicit Folder(Rule& rule) : rule_(rule) {}

    void run() {
        for (bool again = true; again;) {
            for (Clause& c : rule_.body) each_term(c, fold);
            for (Head& h : rule_.heads) each_term(h, fold);
            again = propagate();
        }
        std::erase_if(rule_.body,
                      [](const Clause& c) { return c.kind == Clause::Kind::Test && c.test.op == Op::Bool && c.test.integer != 0; });
    }

  private:
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
                const auto replace = [&](Term& t) { substitute(t, variable, value); };
                for (Clause& other : rule_.body) each_term(other, replace);
                for (Head& h : rule_.heads) each_term(h, replace);
                return true;
            }
        }
        return false;
    }

    bool bound_by_name(VariableId v) const {
        bool found = rule_.selected == v || rule_.site == v;
        const auto note = [&](VariableId bound) { found = found || bound == v; };
        const auto look = [&](const auto& part) { each_part(part, [](const Term&) {}, note); };
        each_clause(rule_.body, look);
        each_head(rule_.heads, [&](const Head& h) {
            look(h);
            each_clause(h.body, look);
        });
        return found;
    }

    Rule& rule_;
};

}  // namespace

void fold_constants(check::Program& program) {
    for (Rule& rule : program.rules) Folder(rule).run();
}

}  // namespace meld::plan
