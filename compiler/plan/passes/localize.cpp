// Pass: localization. After it every atom of a rule is at its execution site or at a direct neighbour of it, and everything that is read at
// a neighbour is stored there. Atoms further away move into an auxiliary at the neighbour in between:
//     p(A, X) :- neighbor(A, B), neighbor(B, C), q(C, X).
// becomes
//     p@1.far1(B, X) :- neighbor(B, C), q(C, X).      p(A, X) :- neighbor(A, B), p@1.far1(B, X).
// and the same again for the auxiliary, until nothing is further than one link.
#include <algorithm>
#include <functional>
#include <map>

#include "compiler/check/program/library.h"
#include "compiler/check/program/op_info.h"
#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

bool is_neighbor(const Program& program, const Atom& a) { return meld::is_link(program.predicates[a.predicate].world); }

class Localizer {
  public:
    Localizer(Program& program, RuleId id) : program_(program), id_(id) {}

    void run() {
        Rule rule = std::move(program_.rules[id_]);
        // A sum and a count depend on every derivation, so the values that distinguish two derivations must reach the head's catom.
        const bool counted = !rule.linear && combines(program_.predicates[rule.heads[0].atom.predicate].aggregate);
        const std::vector<Clause> links = links_of(rule.body);
        localize_body(rule, rule.body, {}, {}, {}, counted ? Matches::Counted : Matches::Any);
        localize_heads(rule, rule.heads, rule.body, links);
        program_.rules[id_] = std::move(rule);
    }

  private:
    // Whether it matters in how many ways a body is satisfied, as inside an aggregate.
    enum class Matches { Any, Counted };

    std::vector<Clause> links_of(const std::vector<Clause>& body) const {
        std::vector<Clause> links;
        std::copy_if(body.begin(), body.end(), std::back_inserter(links),
                     [&](const Clause& c) { return c.kind == Clause::Kind::Atom && is_route(program_, c.atom); });
        return links;
    }

    // Adds the direct neighbours of the execution site by the links of these clauses, not of those inside them.
    void direct(const Rule& rule, const std::vector<Clause>& body, Variables& out) const {
        for (const Clause& c : body) {
            if (c.kind != Clause::Kind::Atom || !is_route(program_, c.atom)) continue;
            const VariableId a = c.atom.arguments[0].variable, b = c.atom.arguments[1].variable;
            if (a == rule.site && b != rule.site) out.insert(b);
            if (b == rule.site && a != rule.site) out.insert(a);
        }
    }

    // Whether the atom must move to an auxiliary: it is not at the execution site, and it is either further away or not stored.
    bool is_far(const Rule& rule, const Atom& a, const Variables& near) const {
        const VariableId at = a.arguments[0].variable;
        if (at == rule.site) return false;
        if (!near.contains(at)) return true;
        if (program_.predicates[a.predicate].world == WorldSource::None) return false;
        return !(is_neighbor(program_, a) && a.arguments[1].is_variable() && a.arguments[1].variable == rule.site);
    }

    bool any_far(const Rule& rule, const std::vector<Clause>& body, const Variables& near) const {
        return std::any_of(body.begin(), body.end(),
                           [&](const Clause& c) { return c.kind == Clause::Kind::Atom && is_far(rule, c.atom, near); });
    }

    // links: those of the bodies around this one. They lead to the catoms of a negation or a comprehension too.
    void localize_body(Rule& rule, std::vector<Clause>& body, Variables near, std::vector<const std::vector<Clause>*> around,
                       std::vector<Clause> links, Matches matches) {
        if (matches == Matches::Counted) name_anonymous(rule, body);
        // Only positive links reach; those inside a negation serve that negation alone.
        direct(rule, body, near);
        const std::vector<Clause> own = links_of(body);
        while (any_far(rule, body, near)) move_one(rule, body, near, around, links, matches);
        around.push_back(&body);
        links.insert(links.end(), own.begin(), own.end());
        for (Clause& c : body)
            if (!c.inner.empty())
                localize_body(rule, c.inner, near, around, links, c.kind == Clause::Kind::Aggregate ? Matches::Counted : Matches::Any);
    }
    // Each fact is a match of its own, also where `_` stands.
    static void name_anonymous(Rule& rule, std::vector<Clause>& body) {
        for (Clause& c : body)
            for (Term& t : c.atom.arguments) {
                if (c.kind != Clause::Kind::Atom || t.op != Op::Anonymous) continue;
                t.op = Op::Variable;
                t.variable = rule.variables.add({"_any", t.span, t.type});
            }
    }

    void localize_heads(Rule& rule, std::vector<Head>& heads, const std::vector<Clause>& around, const std::vector<Clause>& links) {
        Variables near;
        direct(rule, around, near);
        for (Head& h : heads) {
            if (h.body.empty() && h.heads.empty() && h.others.empty()) continue;
            std::vector<Clause> inner = links_of(h.body);
            inner.insert(inner.end(), links.begin(), links.end());
            localize_body(rule, h.body, near, {&around}, links, Matches::Counted);
            std::vector<Clause> inside = around;
            inside.insert(inside.end(), h.body.begin(), h.body.end());
            localize_heads(rule, h.heads, inside, inner);
            localize_heads(rule, h.others, around, links);
        }
    }

    // The catoms beyond `via`, without passing the execution site or another neighbour.
    Variables beyond(const Rule& rule, const std::vector<Clause>& body, const std::vector<Clause>& links, VariableId via,
                     const Variables& near) const {
        Variables seen{via};
        const auto follow = [&](const Clause& c) {
            if (c.kind != Clause::Kind::Atom || !is_route(program_, c.atom)) return false;
            const VariableId a = c.atom.arguments[0].variable, b = c.atom.arguments[1].variable;
            bool grew = false;
            for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
                if (seen.contains(from) && to != rule.site && !near.contains(to)) grew = seen.insert(to) || grew;
            return grew;
        };
        for (bool grew = true; grew;) {
            grew = false;
            for (const auto* clauses : {&body, &links})
                for (const Clause& c : *clauses) grew = follow(c) || grew;
        }
        return seen;
    }

    void move_one(Rule& rule, std::vector<Clause>& body, const Variables& near, const std::vector<const std::vector<Clause>*>& around,
                  const std::vector<Clause>& links, Matches matches) {
        const auto far = std::find_if(body.begin(), body.end(),
                                      [&](const Clause& c) { return c.kind == Clause::Kind::Atom && is_far(rule, c.atom, near); });
        const VariableId at = far->atom.arguments[0].variable;
        VariableId via;
        for (const VariableId n : near)
            if (!via.valid() && beyond(rule, body, links, n, near).contains(at)) via = n;
        MELD_CHECK(via.valid(), "rule {}: no neighbour leads to {}", rule.name, rule.variables[at].name);
        const Variables region = beyond(rule, body, links, via, near);
        MELD_ASSERT(region.contains(at) && !region.contains(rule.site), "rule {}: {} is beyond no neighbour", rule.name,
                    rule.variables[at].name);

        std::vector<Clause> moved, kept;
        for (Clause& c : body) {
            const bool goes = c.kind == Clause::Kind::Atom && region.contains(c.atom.arguments[0].variable) &&
                              (is_far(rule, c.atom, near) || (is_route(program_, c.atom) && region.contains(c.atom.arguments[1].variable)));
            (goes ? moved : kept).push_back(c);
        }
        Variables counted;
        if (matches == Matches::Counted) counted = bound_by(moved);
        // The way to a catom that a body around this one has named.
        for (const Clause& c : links)
            if (region.contains(c.atom.arguments[0].variable) && region.contains(c.atom.arguments[1].variable)) moved.push_back(c);
        split_expressions(rule, moved, kept);
        move_tests(rule, moved, kept);
        move_inner(rule, moved, kept, around, region, near);

        MELD_ASSERT(!moved.empty(), "rule {}: nothing moves to {}", rule.name, rule.variables[via].name);
        // The variables of the moved part that the rest of the rule needs.
        const Variables inside = bound_by(moved);
        Variables outside = counted;
        for (const Clause& c : kept) each_variable(c, [&](VariableId v) { outside.insert(v); });
        used_around(rule, around, outside);
        std::vector<VariableId> shared;
        for (const VariableId v : inside)
            if (v != via && outside.contains(v)) shared.push_back(v);

        kept.push_back(make_auxiliary(rule, via, shared, moved));
        body = std::move(kept);
    }

    // The variables that the facts and tests of these clauses bind.
    static Variables bound_by(const std::vector<Clause>& clauses) {
        Variables bound;
        for (const Clause& c : clauses) {
            if (c.kind == Clause::Kind::Aggregate)
                bound.insert(c.variable);
            else if (c.kind != Clause::Kind::Not)
                each_variable(c, [&](VariableId v) { bound.insert(v); });
        }
        return bound;
    }
    static void used_around(const Rule& rule, const std::vector<const std::vector<Clause>*>& around, Variables& out) {
        for (const auto* other : around)
            for (const Clause& c : *other) each_variable(c, [&](VariableId v) { out.insert(v); });
        for (const Head& h : rule.heads) each_variable(h, [&](VariableId v) { out.insert(v); });
        if (rule.selected.valid()) out.insert(rule.selected);
    }

    // q(C, X + K) becomes q(C, Y), Y = X + K: K may be known here alone.
    static void split_expressions(Rule& rule, std::vector<Clause>& moved, std::vector<Clause>& kept) {
        for (Clause& c : moved)
            for (Term& t : c.atom.arguments) {
                bool any = false;
                each_variable(t, [&](VariableId) { any = true; });
                if (!any || t.is_variable()) continue;
                Term variable;
                variable.op = Op::Variable;
                variable.type = t.type;
                variable.span = t.span;
                variable.variable = rule.variables.add({"_value", t.span, t.type});
                Clause equal{.kind = Clause::Kind::Test, .span = t.span};
                equal.test.op = Op::Equal;
                equal.test.type = Type::Bool;
                equal.test.span = t.span;
                equal.test.operands = {variable, std::move(t)};
                t = std::move(variable);
                kept.push_back(std::move(equal));
            }
    }

    // A negation or an aggregate about catoms beyond the neighbour in between moves with them, if everything that it shares with the rest
    // of the rule is known there. Otherwise it stays, and the facts it reads are sent to it.
    static void move_inner(const Rule& rule, std::vector<Clause>& moved, std::vector<Clause>& kept,
                           const std::vector<const std::vector<Clause>*>& around, const Variables& region, const Variables& near) {
        const Variables known = bound_by(moved);
        for (std::size_t i = 0; i < kept.size();) {
            bool beyond_via = false;
            each_atom(kept[i].inner, [&](const Atom& a, bool) {
                beyond_via = beyond_via || (region.contains(a.arguments[0].variable) && !near.contains(a.arguments[0].variable));
            });
            const VariableId result = kept[i].kind == Clause::Kind::Aggregate ? kept[i].variable : VariableId();
            Variables elsewhere = bound_by(kept);
            used_around(rule, around, elsewhere);
            bool all = beyond_via;
            each_variable(kept[i], [&](VariableId v) { all = all && (v == result || known.contains(v) || !elsewhere.contains(v)); });
            if (!all) {
                ++i;
                continue;
            }
            moved.push_back(kept[i]);
            kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
        }
    }
    // Tests over values that the moved part knows move with it. One that may guard an expression that stays is also kept.
    void move_tests(const Rule& rule, std::vector<Clause>& moved, std::vector<Clause>& kept) {
        Variables known, computed;
        for (const Clause& c : moved)
            if (c.kind == Clause::Kind::Atom) each_variable(c, [&](VariableId v) { known.insert(v); });
        for (const Clause& c : kept) partial_operands(c.test, computed);
        each_head(rule.heads, [&](const Head& h) {
            for (const Term& t : h.atom.arguments) partial_operands(t, computed);
            partial_operands(h.term, computed);
        });
        for (std::size_t i = 0; i < kept.size();) {
            bool all = kept[i].kind == Clause::Kind::Test, guards = false;
            if (all)
                each_variable(kept[i].test, [&](VariableId v) {
                    all = all && known.contains(v);
                    guards = guards || computed.contains(v);
                });
            // Random values are drawn where the rule runs, and once.
            all = all && !is_random(program_, kept[i].test);
            if (all) moved.push_back(kept[i]);
            if (all && !guards)
                kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
            else
                ++i;
        }
    }
    // The variables of operations that have no value for some operands.
    static void partial_operands(const Term& term, Variables& out) {
        each_subterm(term, [&](const Term& t) {
            if (info(t.op).has(OpInfo::kPartial)) each_variable(t, [&](VariableId v) { out.insert(v); });
        });
    }

    // Adds the auxiliary predicate and its rule; returns the atom that stands for the moved clauses.
    Clause make_auxiliary(const Rule& rule, VariableId via, const std::vector<VariableId>& shared, const std::vector<Clause>& moved) {
        Predicate p;
        p.name = fmt::format("{}.far{}", rule.name, ++made_);
        p.span = rule.span;
        p.auxiliary = true;
        p.arguments.push_back({Type::Node, rule.variables[via].name});
        for (const VariableId v : shared) p.arguments.push_back({rule.variables[v].type, rule.variables[v].name});
        const PredicateId id = program_.predicates.add(p);
        Rule auxiliary;
        auxiliary.name = p.name;
        auxiliary.line = rule.line;
        auxiliary.span = rule.span;
        auxiliary.variables = rule.variables;
        auxiliary.site = via;
        auxiliary.body = moved;
        Atom atom;
        atom.predicate = id;
        atom.span = rule.span;
        const auto variable = [&](VariableId v) {
            Term t;
            t.op = Op::Variable;
            t.type = rule.variables[v].type;
            t.variable = v;
            t.span = rule.span;
            return t;
        };
        atom.arguments.push_back(variable(via));
        for (const VariableId v : shared) atom.arguments.push_back(variable(v));
        Head head{.kind = Head::Kind::Fact, .atom = atom, .span = rule.span};
        auxiliary.heads = {head};
        auxiliary.text = print(program_, auxiliary);
        program_.rules.add(std::move(auxiliary));
        Clause c{.kind = Clause::Kind::Atom, .atom = atom, .span = rule.span};
        return c;
    }

    Program& program_;
    RuleId id_;
    int made_ = 0;
};

}  // namespace

void localize(Program& program) {
    // Rules added on the way are localized in their turn.
    for (std::size_t i = 0; i < program.rules.count(); ++i) Localizer(program, RuleId(i)).run();
}

}  // namespace meld::plan
