#include "compiler/lint/guarded.h"

#include <algorithm>
#include <map>

#include "compiler/check/program/improvement.h"
#include "compiler/lint/contradiction.h"
#include "compiler/lint/linear_form.h"

namespace meld::lint {

using namespace check;

namespace {

// Rules that lie between reading a value and deriving the next one; longer chains, and more ways through them, are not searched.
constexpr int kMaxBetween = 3;
constexpr int kMaxWays = 200;

bool same(const Term& a, const Term& b) {
    return a.op == b.op && a.variable == b.variable && a.integer == b.integer && a.real == b.real && a.text == b.text &&
           a.constant == b.constant && a.function == b.function &&
           std::equal(a.operands.begin(), a.operands.end(), b.operands.begin(), b.operands.end(), same);
}

bool same_group(const Atom& a, const Atom& b, const Predicate& p) {
    for (std::size_t i = 0; i < p.aggregate_at; ++i)
        if (!same(a.arguments[i], b.arguments[i])) return false;
    return true;
}

Clause equality(Term variable, Term value) {
    Clause c{.kind = Clause::Kind::Test, .span = value.span};
    c.test = {.op = Op::Equal, .type = Type::Bool, .span = value.span, .operands = {std::move(variable), std::move(value)}};
    return c;
}

// The rule with the body of `inner` in the place of a fact that `inner` derives.
Rule unfolded(const Rule& rule, std::size_t at, const Rule& inner) {
    Rule out = rule;
    const Atom read = rule.body[at].atom;
    const Atom& made = inner.heads[0].atom;
    std::map<VariableId, VariableId> names;
    std::vector<Clause> body(rule.body.begin(), rule.body.begin() + static_cast<std::ptrdiff_t>(at));
    std::vector<std::size_t> equal;
    for (std::size_t i = 0; i < made.arguments.size(); ++i) {
        const Term &to = made.arguments[i], &from = read.arguments[i];
        if (to.is_variable() && from.is_variable() && names.emplace(to.variable, from.variable).second) continue;
        if (from.op != Op::Anonymous) equal.push_back(i);
    }
    const auto rename = [&](VariableId& v) {
        if (!v.valid()) return;
        if (!names.contains(v)) names[v] = out.variables.add(inner.variables[v]);
        v = names[v];
    };
    for (Clause c : inner.body) {
        rewrite_variables(c, rename);
        body.push_back(std::move(c));
    }
    for (const std::size_t i : equal) {
        Term value = made.arguments[i];
        rewrite_variables(value, rename);
        body.push_back(equality(read.arguments[i], std::move(value)));
    }
    body.insert(body.end(), rule.body.begin() + static_cast<std::ptrdiff_t>(at) + 1, rule.body.end());
    out.body = std::move(body);
    return out;
}

class GuardedSearch {
  public:
    GuardedSearch(const Program& program, const Stratum& stratum) : program_(program), stratum_(stratum) {}

    std::optional<Replaced> run() {
        for (const RuleId id : stratum_.rules) {
            const Rule& rule = program_.rules[id];
            const Predicate& p = program_.predicates[rule.heads[0].atom.predicate];
            if (!keeps_best(p.aggregate) || p.needs_all() || rule.heads[0].delay.op != Op::Anonymous) continue;
            // What follows from a literal, replaced_by_itself() knows better.
            const Term& made = rule.heads[0].atom.arguments[p.aggregate_at];
            if (made.op == Op::Constant || literal(made)) continue;
            ways_ = 0;
            if (auto found = search(rule)) return found;
        }
        return std::nullopt;
    }

  private:
    std::optional<Replaced> search(const Rule& rule) {
        if (++ways_ > kMaxWays) return std::nullopt;
        if (auto found = guarded(rule)) return found;
        if (between_.size() == kMaxBetween) return std::nullopt;
        const PredicateId head = rule.heads[0].atom.predicate;
        for (std::size_t i = 0; i < rule.body.size(); ++i) {
            const Clause& c = rule.body[i];
            if (c.kind != Clause::Kind::Atom || c.atom.predicate == head || !stratum_.contains(c.atom.predicate)) continue;
            for (const Rule* inner : derived_by(c.atom.predicate)) {
                between_.push_back({head, c.atom.predicate, c.atom.span});
                if (auto found = search(unfolded(rule, i, *inner))) return found;
                between_.pop_back();
            }
        }
        return std::nullopt;
    }

    // The rules of a predicate, if each of its facts is what a rule derives: those of an aggregate may lose against each other.
    std::vector<const Rule*> derived_by(PredicateId id) const {
        const Predicate& p = program_.predicates[id];
        std::vector<const Rule*> rules;
        for (const RuleId r : stratum_.rules) {
            const Rule& rule = program_.rules[r];
            if (rule.heads[0].atom.predicate != id) continue;
            if (rule.heads[0].delay.op != Op::Anonymous) return {};
            rules.push_back(&rule);
        }
        const bool alone = keeps_best(p.aggregate) && !p.needs_all() && rules.size() == 1 && rules[0]->body.size() == 1;
        return p.aggregate == Aggregate::None || alone ? rules : std::vector<const Rule*>{};
    }

    // If a rule reads the value of its head's group and tests it. Other support of the new value is not searched for: the test would be
    // useless if there were any.
    std::optional<Replaced> guarded(const Rule& rule) const {
        const Atom& head = rule.heads[0].atom;
        const Predicate& p = program_.predicates[head.predicate];
        const Term& made = head.arguments[p.aggregate_at];
        for (const Clause& c : rule.body) {
            if (c.kind != Clause::Kind::Atom || c.atom.predicate != head.predicate || !same_group(c.atom, head, p)) continue;
            const Term& there = c.atom.arguments[p.aggregate_at];
            if (!there.is_variable() || same(there, made)) continue;
            const Improvement improvement(program_, rule, c.atom, there.variable, p.aggregate);
            if (improvement.worse(made)) continue;
            if (const Term* lost = improvement.first_lost())
                return Replaced{.predicate = head.predicate,
                                .made = made.span,
                                .guard = compares(*lost, made, there.variable),
                                .asked = lost->span,
                                .between = between_};
        }
        return std::nullopt;
    }
    // Whether the test compares the value with the new one.
    static bool compares(const Term& test, const Term& made, VariableId there) {
        bool with_there = false, with_made = false;
        each_variable(test, [&](VariableId v) {
            with_there = with_there || v == there;
            each_variable(made, [&](VariableId w) { with_made = with_made || v == w; });
        });
        return with_there && with_made;
    }

    const Program& program_;
    const Stratum& stratum_;
    int ways_ = 0;
    std::vector<Replaced::Between> between_;
};

}  // namespace

std::optional<Replaced> guarded_by_itself(const Program& program, const Stratum& stratum) { return GuardedSearch(program, stratum).run(); }

}  // namespace meld::lint
