// Pass 4: range restriction. Every variable of a head, a test or a negation gets its value from a positive fact or from
// an equality; order does not matter, the planner reorders. Assumes homes are known: the home catom is always bound.
#include <set>

#include "compiler/check/check.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

using Bound = std::set<VariableId>;

bool all_bound(const Term& term, const Bound& bound) {
    bool all = true;
    each_free_use(term, [&](const Term& t) { all = all && bound.contains(t.variable); });
    return all;
}

// In L = [X | Rest] with L known, X and Rest get their values.
bool bind_parts(const Term& test, Bound& bound) {
    const TakeApart parts = taken_apart(test);
    if (!parts || !all_bound(*parts.value, bound)) return false;
    bool changed = false;
    for (const Term& part : parts.constructor->operands)
        if (part.is_variable()) changed = bound.insert(part.variable).second || changed;
    return changed;
}

// Adds what the positive clauses bind, to a fixpoint.
void bind(const std::vector<Clause>& body, Bound& bound) {
    for (const Clause& c : body)
        if (c.kind == Clause::Kind::Atom)
            for (const Term& a : c.atom.arguments)
                if (a.is_variable()) bound.insert(a.variable);
    for (bool changed = true; changed;) {
        changed = false;
        for (const Clause& c : body) {
            if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) continue;
            for (int side = 0; side < 2; ++side) {
                const Term& target = c.test.operands[static_cast<std::size_t>(side)];
                const Term& value = c.test.operands[static_cast<std::size_t>(1 - side)];
                if (target.is_variable() && !bound.contains(target.variable) && all_bound(value, bound)) changed = bound.insert(target.variable).second || changed;
            }
            changed = bind_parts(c.test, bound) || changed;
        }
    }
}

class Bindings {
  public:
    Bindings(const Program& program, const Rule& rule, diagnostics::Reporter& report) : program_(program), rule_(rule), report_(report) {}

    void run() {
        Bound bound;
        if (rule_.home.valid()) bound.insert(rule_.home);
        bind(rule_.body, bound);
        body(rule_.body, bound);
        heads(rule_.heads, bound);
    }

  private:
    void need(const Term& term, const Bound& bound, const char* what) {
        each_free_use(term, [&](const Term& t) {
            if (bound.contains(t.variable) || !reported_.insert(t.variable).second) return;
            report_.add(Kind::UnboundVariable, t.span, fmt::format("`{}` has no value {}", rule_.variables[t.variable].name, what)).help =
                fmt::format("use it in a fact of the body, or set it with `{} = ...`", rule_.variables[t.variable].name);
        });
    }
    // In Y = Z + 1 without a value for Z, that Y has none either goes without saying.
    void need_of_test(const Term& test, const Bound& bound) {
        if (test.op == Op::Equal)
            for (const std::size_t side : {0u, 1u}) {
                const Term &target = test.operands[side], &value = test.operands[1 - side];
                if (!target.is_variable() || bound.contains(target.variable) || value.is_variable()) continue;
                need(value, bound, "in this condition");
                reported_.insert(target.variable);
            }
        need(test, bound, "in this condition");
    }
    void body(const std::vector<Clause>& clauses, const Bound& bound) {
        for (const Clause& c : clauses) {
            for (const Term& a : c.atom.arguments) need(a, bound, "here");
            if (c.kind == Clause::Kind::Test) need_of_test(c.test, bound);
            if (c.kind == Clause::Kind::Not) {
                Bound inner = bound;
                bind(c.inner, inner);
                body(c.inner, inner);
            }
        }
    }
    void heads(const std::vector<Head>& all, const Bound& bound) {
        for (const Head& h : all) {
            Bound inner = bound;
            if (h.kind == Head::Kind::Comprehension) {
                bind(h.body, inner);
                body(h.body, inner);
            }
            for (const Term& a : h.atom.arguments) need(a, inner, "in this head");
            heads(h.heads, inner);
        }
    }

    const Program& program_;
    const Rule& rule_;
    diagnostics::Reporter& report_;
    Bound reported_;
};

}  // namespace

void check_bindings(Program& program, diagnostics::Reporter& report) {
    for (Rule& rule : program.rules) {
        if (rule.refused) continue;
        const std::size_t errors = report.error_count();
        Bindings(program, rule, report).run();
        rule.refused = report.error_count() > errors;
        // A variable that stands once in a rule is often a slip of the pen; `_` or `_Name` says it is meant.
        for (const VariableId v : rule.used_once)
            if (!rule.refused)
                report.add(Kind::SingleUse, rule.variables[v].span, fmt::format("`{}` is used once in this rule", rule.variables[v].name)).help = "write `_` if any value will do";
    }
}

}  // namespace meld::check
