// Pass: aggregates before sends. If neighbours read many rows of a predicate only for their least or greatest value, the owner computes the
// best of them first, and one value crosses the link instead of the rows:
//     cheapest(B, V) :- neighbor(A, B), offer(A, K, V), K > 0.        (cheapest(node, min int V))
// becomes
//     cheapest@1.best1(A, V) :- offer(A, K, V), K > 0.      cheapest(B, V) :- neighbor(A, B), cheapest@1.best1(A, V).
// The least of least values is the least of all, so results do not change. Sums and counts are left alone: a sum of sums may overflow where
// the sum does not, and floats would be added in another order. Assumes localized rules. A predicate that some other neighbour still reads
// row by row is left alone too, because its rows cross the links anyway.
#include <algorithm>
#include <map>
#include <set>

#include "compiler/check/program/op_info.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

// A clause of a rule that reads a predicate at a neighbour, and how the best of its rows can be taken there.
struct Push {
    RuleId rule;
    std::size_t clause = 0;
    VariableId value;
    std::vector<VariableId> kept;    // The atom's other variables that the rest of the rule needs.
    std::vector<std::size_t> tests;  // Clauses that move with it.
};

// Tests that have an outcome for all values.
bool is_total(const Term& term) {
    return all_subterms(term, [](const Term& t) { return info(t.op).has(OpInfo::kMoves); });
}

class Pusher {
  public:
    explicit Pusher(Program& program) : program_(program) {}

    void run() {
        std::map<PredicateId, std::vector<Push>> pushes;
        std::set<PredicateId> read_by_row;
        for (const RuleId id : program_.rules.ids()) {
            const Rule& rule = program_.rules[id];
            std::set<const Atom*> pushed;
            for (std::size_t i = 0; i < rule.body.size(); ++i) {
                Push push{.rule = id, .clause = i, .value = {}, .kept = {}, .tests = {}};
                if (!can_push(rule, push)) continue;
                pushes[rule.body[i].atom.predicate].push_back(push);
                pushed.insert(&rule.body[i].atom);
            }
            const auto read = [&](const Atom& a, bool) {
                if (a.arguments[0].variable != rule.site && !pushed.contains(&a)) read_by_row.insert(a.predicate);
            };
            each_atom(rule.body, read);
            each_head(rule.heads, [&](const Head& h) { each_atom(h.body, read); });
        }
        std::set<RuleId> rewritten;
        for (const auto& [predicate, all] : pushes) {
            if (read_by_row.contains(predicate)) continue;
            // A rule changes once: the numbers of its clauses do not hold after that.
            std::set<RuleId> rules;
            for (const Push& p : all) rules.insert(p.rule);
            const bool again = std::any_of(rules.begin(), rules.end(), [&](RuleId r) { return rewritten.contains(r); });
            if (again || rules.size() < all.size()) continue;
            for (const Push& p : all) apply(p);
            rewritten.merge(rules);
        }
    }

  private:
    bool can_push(const Rule& rule, Push& push) const {
        if (rule.linear || rule.body[push.clause].kind != Clause::Kind::Atom) return false;
        const Atom& atom = rule.body[push.clause].atom;
        const Predicate& p = program_.predicates[atom.predicate];
        const Atom& head = rule.heads[0].atom;
        const Predicate& h = program_.predicates[head.predicate];
        if (atom.arguments[0].variable == rule.site || p.kind != PredicateKind::Persistent || p.world != WorldSource::None || p.route)
            return false;
        if (!keeps_best(h.aggregate) || h.complete_link.valid()) return false;
        const Term& best = head.arguments[h.aggregate_at];
        if (!best.is_variable() || best.type != h.arguments[h.aggregate_at].type) return false;
        push.value = best.variable;
        if (!reads(atom, push) || derives(head.predicate, atom.predicate)) return false;

        const Variables own = variables_of(atom);
        Variables elsewhere;
        for (std::size_t i = 0; i < head.arguments.size(); ++i)
            if (i != h.aggregate_at) each_variable(head.arguments[i], [&](VariableId v) { elsewhere.insert(v); });
        each_variable(rule.heads[0].delay, [&](VariableId v) { elsewhere.insert(v); });
        for (std::size_t i = 0; i < rule.body.size(); ++i) {
            if (i == push.clause) continue;
            const Clause& c = rule.body[i];
            bool moves = c.kind == Clause::Kind::Test && is_total(c.test), any = false;
            each_variable(c, [&](VariableId v) {
                moves = moves && own.contains(v) && v != atom.arguments[0].variable;
                any = true;
            });
            if (moves && any)
                push.tests.push_back(i);
            else
                each_variable(c, [&](VariableId v) { elsewhere.insert(v); });
        }
        if (elsewhere.contains(push.value)) return false;
        for (const VariableId v : own)
            if (v != push.value && v != atom.arguments[0].variable && elsewhere.contains(v)) push.kept.push_back(v);
        return narrows(p, atom, push);
    }

    // The value stands once in the atom, and all else there is a variable, a literal, or nothing.
    static bool reads(const Atom& atom, const Push& push) {
        int times = 0;
        for (const Term& t : atom.arguments) {
            const bool plain = t.is_variable() || t.op == Op::Anonymous || t.op == Op::Int || t.op == Op::Bool;
            if (!plain) return false;
            times += t.is_variable() && t.variable == push.value;
        }
        return times == 1 && atom.arguments[0].variable != push.value;
    }

    static Variables variables_of(const Atom& atom) {
        Variables out;
        for (const Term& t : atom.arguments) each_variable(t, [&](VariableId v) { out.insert(v); });
        return out;
    }

    // Whether several rows become one: some argument of the group is not kept.
    static bool narrows(const Predicate& p, const Atom& atom, const Push& push) {
        for (std::size_t i = 1; i <= group_arguments(p); ++i) {
            const Term& t = atom.arguments[i];
            if (t.op == Op::Anonymous) return true;
            if (t.is_variable() && t.variable != push.value && std::find(push.kept.begin(), push.kept.end(), t.variable) == push.kept.end())
                return true;
        }
        return false;
    }

    // Whether `to` is derived from `from`, over any number of rules: then the auxiliary would be part of the recursion.
    bool derives(PredicateId from, PredicateId to) const {
        std::set<PredicateId> seen{to};
        std::vector<PredicateId> open{to};
        while (!open.empty()) {
            const PredicateId p = open.back();
            open.pop_back();
            if (p == from) return true;
            for (const Rule& rule : program_.rules) {
                if (rule.linear || rule.heads[0].atom.predicate != p) continue;
                each_atom(rule.body, [&](const Atom& a, bool) {
                    if (seen.insert(a.predicate).second) open.push_back(a.predicate);
                });
            }
        }
        return false;
    }

    static Term variable(const Rule& rule, VariableId v) {
        return {.op = Op::Variable, .type = rule.variables[v].type, .span = rule.span, .variable = v};
    }

    void apply(const Push& push) {
        Rule rule = program_.rules[push.rule];
        MELD_EXPECT(push.value.valid() && push.clause < rule.body.size(), "rule {}", rule.name);
        MELD_EXPECT(std::is_sorted(push.tests.begin(), push.tests.end()), "rule {}: tests are taken out from the last on", rule.name);
        const Atom from = rule.body[push.clause].atom;
        const VariableId at = from.arguments[0].variable;
        Predicate p;
        p.name = fmt::format("{}.best{}", rule.name, ++made_[rule.name]);
        p.span = rule.span;
        p.auxiliary = true;
        p.arguments.push_back({Type::Node, rule.variables[at].name});
        for (const VariableId v : push.kept) p.arguments.push_back({rule.variables[v].type, rule.variables[v].name});
        p.aggregate = program_.predicates[rule.heads[0].atom.predicate].aggregate;
        p.aggregate_at = p.arguments.size();
        p.arguments.push_back({rule.variables[push.value].type, rule.variables[push.value].name});

        Atom best;
        best.predicate = program_.predicates.add(std::move(p));
        best.span = rule.span;
        best.arguments.push_back(variable(rule, at));
        for (const VariableId v : push.kept) best.arguments.push_back(variable(rule, v));
        best.arguments.push_back(variable(rule, push.value));

        Rule made;
        made.name = program_.predicates[best.predicate].name;
        made.line = rule.line;
        made.span = rule.span;
        made.variables = rule.variables;
        made.site = at;
        made.body.push_back(rule.body[push.clause]);
        for (const std::size_t t : push.tests) made.body.push_back(rule.body[t]);
        made.heads.push_back({.kind = Head::Kind::Fact, .atom = best, .span = rule.span});
        made.text = print(program_, made);

        rule.body[push.clause].atom = best;
        for (auto t = push.tests.rbegin(); t != push.tests.rend(); ++t)
            rule.body.erase(rule.body.begin() + static_cast<std::ptrdiff_t>(*t));
        program_.rules[push.rule] = std::move(rule);
        program_.rules.add(std::move(made));
    }

    Program& program_;
    std::map<std::string, int> made_;
};

}  // namespace

void push_aggregates(Program& program) { Pusher(program).run(); }

}  // namespace meld::plan
