// Pass 4: range restriction. Every variable of a head, a test or a negation gets its value from a positive fact or from
// an equality; order does not matter, the planner reorders. Assumes execution sites: the catom there is always bound.
#include <algorithm>
#include <map>

#include "compiler/check/check.h"
#include "compiler/check/program/fact_form.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

using Bound = Variables;

bool all_bound(const Term& term, const Bound& bound) {
    return all_free(term, [&](VariableId v) { return bound.contains(v); });
}

// In L = [X | Rest] with L known, X and Rest get their values.
bool bind_parts(const Term& test, Bound& bound) {
    const TakeApart parts = taken_apart(test);
    if (!parts || !all_bound(*parts.value, bound)) return false;
    bool changed = false;
    for (const Term& part : parts.constructor->operands)
        if (part.is_variable()) changed = bound.insert(part.variable) || changed;
    return changed;
}

class Bindings {
  public:
    Bindings(const Program& program, const Rule& rule, diagnostics::Reporter& report) : program_(program), rule_(rule), report_(report) {}

    void run() {
        uses_.assign(rule_.variables.count(), 0);
        const auto use = [&](VariableId v) { ++uses_[v.index()]; };
        for (const Clause& c : rule_.body) each_variable(c, use);
        for (const Head& h : rule_.heads) each_variable(h, use);
        Bound bound;
        if (rule_.site.valid()) bound.insert(rule_.site);
        bind(rule_.body, bound);
        body(rule_.body, bound);
        if (rule_.selected.valid()) selected(bound);
        heads(rule_.heads, bound);
    }

  private:
    // Adds what the positive clauses bind, to a fixpoint.
    void bind(const std::vector<Clause>& clauses, Bound& bound) const {
        for (const Clause& c : clauses)
            if (c.kind == Clause::Kind::Atom || c.kind == Clause::Kind::Delta)
                for (const Term& a : c.atom.arguments)
                    if (a.is_variable()) bound.insert(a.variable);
        for (bool changed = true; changed;) {
            changed = false;
            for (const Clause& c : clauses) {
                if (c.kind == Clause::Kind::Aggregate && !bound.contains(c.variable) && shared_bound(c, bound))
                    changed = bound.insert(c.variable) || changed;
                if (c.kind == Clause::Kind::Element && !bound.contains(c.variable) && all_bound(c.test, bound))
                    changed = bound.insert(c.variable) || changed;
                if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) continue;
                for (const std::size_t side : {0u, 1u}) {
                    const Term &target = c.test.operands[side], &value = c.test.operands[1 - side];
                    if (target.is_variable() && !bound.contains(target.variable) && all_bound(value, bound))
                        changed = bound.insert(target.variable) || changed;
                }
                changed = bind_parts(c.test, bound) || changed;
            }
        }
    }
    // Whether everything that an aggregate shares with the rule around it has a value.
    bool shared_bound(const Clause& aggregate, const Bound& bound) const {
        std::map<VariableId, int> inside;
        for (const Clause& c : aggregate.inner) each_variable(c, [&](VariableId v) { ++inside[v]; });
        each_variable(aggregate.test, [&](VariableId v) { ++inside[v]; });
        return std::all_of(inside.begin(), inside.end(),
                           [&](const auto& use) { return use.second == uses_[use.first.index()] || bound.contains(use.first); });
    }
    void selected(const Bound& bound) {
        const Variable& v = rule_.variables[rule_.selected];
        if (!bound.contains(rule_.selected) && reported_.insert(rule_.selected))
            report_.add(Kind::UnboundVariable, v.span, fmt::format("`{}` has no value in this body", v.name)).help =
                "choose by a variable of a fact of the body";
    }

    // `n-1` as a difference if `n` is a variable of the rule; otherwise empty.
    std::string as_difference(const std::string& name) const {
        const std::size_t minus = name.find('-');
        if (minus == std::string::npos) return "";
        const std::string left = name.substr(0, minus);
        const bool known = std::any_of(rule_.variables.begin(), rule_.variables.end(), [&](const Variable& v) { return v.name == left; });
        return known ? left + " - " + name.substr(minus + 1) : "";
    }

    void need(const Term& term, const Bound& bound, const char* what) {
        each_free_use(term, [&](const Term& t) {
            if (bound.contains(t.variable) || !reported_.insert(t.variable)) return;
            const std::string& name = rule_.variables[t.variable].name;
            auto& d = report_.add(Kind::UnboundVariable, t.span, fmt::format("`{}` has no value {}", name, what));
            const std::string apart = as_difference(name);
            const std::string fact = fact_form_help(program_, name);
            d.help = !apart.empty()  ? fmt::format("`{}` is one name; a difference of lower-case variables has blanks: `{}`", name, apart)
                     : !fact.empty() ? fact
                                     : fmt::format("use it in a fact of the body, or set it with `{} = ...`", name);
            if (!apart.empty()) d.fixes = {diagnostics::write(t.span, apart)};
        });
    }
    // In Y = Z + 1 without a value for Z, it need not be said that Y has none either.
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
            if (c.kind == Clause::Kind::Element) {
                need(c.test, bound, "in this list");
                reported_.insert(c.variable);
            }
            if (c.kind == Clause::Kind::Delta) need(c.test, bound, "in this condition");
            if (c.kind == Clause::Kind::Not || c.kind == Clause::Kind::Aggregate) {
                Bound inner = bound;
                bind(c.inner, inner);
                body(c.inner, inner);
                if (c.kind == Clause::Kind::Not) continue;
                need(c.test, inner, "in what is aggregated");
                need(c.parameter, bound, "in what is aggregated");
                if (!bound.contains(c.variable) && reported_.insert(c.variable))
                    report_
                        .add(Kind::UnboundVariable, c.span,
                             fmt::format("`{}` has no value: something inside the aggregate needs it, or has no value itself",
                                         rule_.variables[c.variable].name))
                        .help = "variables that the aggregate shares with the rest of the rule need a value there";
            }
        }
    }
    void set(const Head& h, const Bound& bound, Bound& inner) {
        if (h.term.op != Op::Fresh) need(h.term, bound, "in this head");
        if (h.term.op != Op::Fresh && bound.contains(h.variable))
            report_
                .add(Kind::SyntaxError, h.span,
                     fmt::format("`{}` has a value already, and a head tests nothing", rule_.variables[h.variable].name))
                .help = "write conditions in the body";
        inner.insert(h.variable);
    }
    void heads(const std::vector<Head>& all, const Bound& bound) {
        for (const Head& h : all) {
            Bound inner = bound;
            bind(h.body, inner);
            body(h.body, inner);
            for (const Term& a : h.atom.arguments) need(a, inner, "in this head");
            if (h.kind == Head::Kind::If) need(h.term, bound, "in this condition");
            if (h.kind == Head::Kind::Set) set(h, bound, inner);
            for (const HeadAggregate& f : h.aggregates) need(f.parameter, bound, "in what a fold starts from");
            Bound last = h.kind == Head::Kind::Aggregate ? bound : inner;
            for (const HeadAggregate& f : h.aggregates) {
                if (f.each.valid() && !inner.contains(f.each) && reported_.insert(f.each))
                    report_.add(Kind::UnboundVariable, h.span, fmt::format("`{}` has no value for a match", rule_.variables[f.each].name))
                        .help = fmt::format("use `{}` in the body of the aggregate: it stands for the value of one match",
                                            rule_.variables[f.each].name);
                last.insert(f.result);
            }
            heads(h.heads, inner);
            heads(h.others, last);
        }
    }

    const Program& program_;
    const Rule& rule_;
    diagnostics::Reporter& report_;
    Bound reported_;
    std::vector<int> uses_;  // Of each variable, in the whole rule.
};

}  // namespace

void check_bindings(Program& program, diagnostics::Reporter& report) {
    for (Rule& rule : program.rules) {
        if (rule.refused) continue;
        const std::size_t errors = report.error_count();
        Bindings(program, rule, report).run();
        rule.refused = report.error_count() > errors;
    }
    for (const Rule& question : program.questions)
        if (!question.refused) Bindings(program, question, report).run();
}

}  // namespace meld::check
