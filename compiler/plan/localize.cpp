// Pass: localization. After it every atom of a rule is at the rule's home or at a direct neighbour of it, and what is
// read at a neighbour is stored there. What lies further out moves into an auxiliary at the neighbour in between:
//     p(A, X) :- neighbor(A, B), neighbor(B, C), q(C, X).
// becomes
//     p@1.far1(B, X) :- neighbor(B, C), q(C, X).      p(A, X) :- neighbor(A, B), p@1.far1(B, X).
// and the same again for the auxiliary, until nothing is further than one link.
#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "compiler/plan/plan.h"

namespace meld::plan {

using namespace check;

namespace {

using Variables = std::set<VariableId>;

bool is_link(const Program& program, const Atom& a) {
    return program.predicates[a.predicate].route && a.arguments.size() > 1 && a.arguments[1].is_variable();
}
bool is_neighbor(const Program& program, const Atom& a) {
    const WorldSource w = program.predicates[a.predicate].world;
    return w == WorldSource::Neighbor || w == WorldSource::NeighborPort;
}

class Localizer {
  public:
    Localizer(Program& program, RuleId id) : program_(program), id_(id) {}

    void run() {
        Rule rule = program_.rules[id_];
        localize_body(rule, rule.body, {}, {});
        localize_heads(rule, rule.heads, rule.body);
        program_.rules[id_] = std::move(rule);
    }

  private:
    // Direct neighbours of the home by the links of these clauses.
    void direct(const Rule& rule, const std::vector<Clause>& body, Variables& out) const {
        each_atom(body, [&](const Atom& a, bool) {
            if (!is_link(program_, a)) return;
            if (a.arguments[0].variable == rule.home) out.insert(a.arguments[1].variable);
            if (a.arguments[1].variable == rule.home) out.insert(a.arguments[0].variable);
        });
        out.erase(rule.home);
    }

    // Whether the atom must move to an auxiliary: not at the home, and either further away or nothing that is stored.
    bool is_far(const Rule& rule, const Atom& a, const Variables& near) const {
        const VariableId at = a.arguments[0].variable;
        if (at == rule.home) return false;
        if (!near.contains(at)) return true;
        if (program_.predicates[a.predicate].world == WorldSource::None) return false;
        return !(is_neighbor(program_, a) && a.arguments[1].is_variable() && a.arguments[1].variable == rule.home);
    }

    bool any_far(const Rule& rule, const std::vector<Clause>& body, const Variables& near) const {
        return std::any_of(body.begin(), body.end(), [&](const Clause& c) { return c.kind == Clause::Kind::Atom && is_far(rule, c.atom, near); });
    }

    void localize_body(Rule& rule, std::vector<Clause>& body, Variables near, std::vector<const std::vector<Clause>*> around) {
        // Only positive links reach; those inside a negation serve that negation alone.
        for (const Clause& c : body)
            if (c.kind == Clause::Kind::Atom) direct(rule, {c}, near);
        while (any_far(rule, body, near)) move_one(rule, body, near, around);
        around.push_back(&body);
        for (std::size_t i = 0; i < body.size(); ++i)
            if (body[i].kind == Clause::Kind::Not) localize_body(rule, body[i].inner, near, around);
    }

    void localize_heads(Rule& rule, std::vector<Head>& heads, const std::vector<Clause>& around) {
        Variables near;
        for (const Clause& c : around)
            if (c.kind == Clause::Kind::Atom) direct(rule, {c}, near);
        for (Head& h : heads) {
            if (h.kind != Head::Kind::Comprehension) continue;
            localize_body(rule, h.body, near, {&around});
            localize_heads(rule, h.heads, h.body);
        }
    }

    // The catoms beyond `via`, without passing the home or another neighbour.
    Variables beyond(const Rule& rule, const std::vector<Clause>& body, VariableId via, const Variables& near) const {
        Variables seen{via};
        for (bool grew = true; grew;) {
            grew = false;
            for (const Clause& c : body) {
                if (c.kind != Clause::Kind::Atom || !is_link(program_, c.atom)) continue;
                const VariableId a = c.atom.arguments[0].variable, b = c.atom.arguments[1].variable;
                for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
                    if (seen.contains(from) && to != rule.home && !near.contains(to)) grew = seen.insert(to).second || grew;
            }
        }
        return seen;
    }

    void move_one(Rule& rule, std::vector<Clause>& body, const Variables& near, const std::vector<const std::vector<Clause>*>& around) {
        const auto far = std::find_if(body.begin(), body.end(), [&](const Clause& c) { return c.kind == Clause::Kind::Atom && is_far(rule, c.atom, near); });
        const VariableId at = far->atom.arguments[0].variable;
        VariableId via;
        for (const VariableId n : near)
            if (!via.valid() && beyond(rule, body, n, near).contains(at)) via = n;
        MELD_CHECK(via.valid(), "rule {}: no neighbour leads to {}", rule.name, rule.variables[at].name);
        const Variables region = beyond(rule, body, via, near);

        std::vector<Clause> moved, kept;
        for (Clause& c : body) {
            const bool goes = c.kind == Clause::Kind::Atom && region.contains(c.atom.arguments[0].variable) &&
                              (is_far(rule, c.atom, near) || (is_link(program_, c.atom) && region.contains(c.atom.arguments[1].variable)));
            (goes ? moved : kept).push_back(c);
        }
        move_negations(moved, kept, region, near);
        move_tests(moved, kept);

        // What the rest of the rule still needs to know of the moved part.
        Variables inside, outside;
        for (const Clause& c : moved) each_variable(c, [&](VariableId v) { inside.insert(v); });
        for (const Clause& c : kept) each_variable(c, [&](VariableId v) { outside.insert(v); });
        for (const auto* other : around)
            for (const Clause& c : *other) each_variable(c, [&](VariableId v) { outside.insert(v); });
        head_variables(rule.heads, outside);
        std::vector<VariableId> shared;
        for (const VariableId v : inside)
            if (v != via && outside.contains(v)) shared.push_back(v);

        kept.push_back(make_auxiliary(rule, via, shared, moved));
        body = std::move(kept);
    }

    // A negation about catoms beyond the neighbour in between moves with them.
    static void move_negations(std::vector<Clause>& moved, std::vector<Clause>& kept, const Variables& region, const Variables& near) {
        for (std::size_t i = 0; i < kept.size();) {
            bool beyond_via = false;
            if (kept[i].kind == Clause::Kind::Not)
                each_atom(kept[i].inner, [&](const Atom& a, bool) { beyond_via = beyond_via || (region.contains(a.arguments[0].variable) && !near.contains(a.arguments[0].variable)); });
            if (!beyond_via) {
                ++i;
                continue;
            }
            moved.push_back(kept[i]);
            kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
        }
    }
    static void move_tests(std::vector<Clause>& moved, std::vector<Clause>& kept) {
        Variables known;
        for (const Clause& c : moved)
            if (c.kind == Clause::Kind::Atom) each_variable(c, [&](VariableId v) { known.insert(v); });
        for (std::size_t i = 0; i < kept.size();) {
            bool all = kept[i].kind == Clause::Kind::Test;
            if (all) each_variable(kept[i].test, [&](VariableId v) { all = all && known.contains(v); });
            if (!all) {
                ++i;
                continue;
            }
            moved.push_back(kept[i]);
            kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
        }
    }

    static void head_variables(const std::vector<Head>& heads, Variables& out) {
        for (const Head& h : heads) {
            for (const Term& t : h.atom.arguments) each_variable(t, [&](VariableId v) { out.insert(v); });
            for (const Clause& c : h.body) each_variable(c, [&](VariableId v) { out.insert(v); });
            head_variables(h.heads, out);
        }
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
        auxiliary.home = via;
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
