// The promises of the passes over programs, checked after each of them. A violation is our bug and ends the process.
#include <algorithm>

#include "compiler/plan/verify.h"

#include "compiler/check/program/well_formed.h"

namespace meld::plan {

using namespace check;

namespace {

using Places = Variables;

void verify_predicate(const Program& program, const Predicate& p) {
    MELD_CHECK(!p.arguments.empty() && p.arguments[0].type == Type::Node, "{} has no catom", p.name);
    MELD_CHECK(p.aggregate == Aggregate::None || (p.aggregate_at > 0 && p.aggregate_at < p.arguments.size()), "{} aggregates argument {}",
               p.name, p.aggregate_at);
    MELD_CHECK((p.aggregate == Aggregate::Custom) == p.fold.valid(), "{} has a function that does not fit its aggregate", p.name);
    for (const Argument& a : p.arguments)
        MELD_CHECK(a.least <= a.greatest, "{} has an argument from {} to {}", p.name, a.least, a.greatest);
    for (const PredicateId other : {p.complete_link, p.returns, p.carries, p.given})
        MELD_CHECK(!other.valid() || other.index() < program.predicates.count(), "{} names no predicate", p.name);
    MELD_CHECK(p.facts.empty() || p.world == WorldSource::Facts, "{} has facts of the text and is no table", p.name);
}

// ---- localization

void add_neighbours(const Program& program, const Rule& rule, const std::vector<Clause>& body, Places& near) {
    for (const Clause& c : body) {
        if (c.kind != Clause::Kind::Atom || !is_route(program, c.atom)) continue;
        const VariableId a = c.atom.arguments[0].variable, b = c.atom.arguments[1].variable;
        if (a == rule.site) near.insert(b);
        if (b == rule.site) near.insert(a);
    }
}

void verify_places(const Program& program, const Rule& rule, const std::vector<Clause>& body, Places near) {
    add_neighbours(program, rule, body, near);
    for (const Clause& c : body) {
        verify_places(program, rule, c.inner, near);
        if (c.kind != Clause::Kind::Atom) continue;
        const VariableId at = c.atom.arguments[0].variable;
        if (at == rule.site) continue;
        const Predicate& p = program.predicates[c.atom.predicate];
        MELD_CHECK(near.contains(at), "rule {} reads {} at {}, which is no neighbour", rule.name, p.name, rule.variables[at].name);
        const bool link_back = is_route(program, c.atom) && c.atom.arguments[1].variable == rule.site;
        MELD_CHECK(p.world == WorldSource::None || link_back, "rule {} reads {} of the world at a neighbour", rule.name, p.name);
    }
}

void verify_head_places(const Program& program, const Rule& rule, const std::vector<Head>& heads, const Places& around) {
    for (const Head& h : heads) {
        verify_places(program, rule, h.body, around);
        Places near = around;
        add_neighbours(program, rule, h.body, near);
        verify_head_places(program, rule, h.heads, near);
        verify_head_places(program, rule, h.others, around);
    }
}

// ---- strata

constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);

std::vector<std::size_t> stratum_of(const Program& program) {
    std::vector<std::size_t> out(program.predicates.count(), kNowhere);
    for (std::size_t i = 0; i < program.strata.size(); ++i)
        for (const PredicateId p : program.strata[i].predicates) {
            MELD_CHECK(out[p.index()] == kNowhere, "{} is in two strata", program.predicates[p].name);
            out[p.index()] = i;
        }
    for (const PredicateId p : program.predicates.ids())
        MELD_CHECK(out[p.index()] != kNowhere, "{} is in no stratum", program.predicates[p].name);
    return out;
}

// What a rule of the stratum `own` reads has been evaluated before, or is evaluated with it.
void verify_reads(const Program& program, const Rule& rule, std::size_t own, const std::vector<std::size_t>& stratum) {
    each_atom(rule.body, [&](const Atom& a, bool negated) {
        const std::size_t other = stratum[a.predicate.index()];
        const Predicate& p = program.predicates[a.predicate];
        const bool at_site = a.arguments[0].variable == rule.site;
        // Exports of neighbours are as of the last tick, so along a tree they may come later in the order.
        const bool along_tree = !at_site && program.strata[own].tree && program.strata[other].tree;
        MELD_CHECK(other <= own || along_tree, "rule {} reads {}, which is evaluated later", rule.name, p.name);
        MELD_CHECK(other != own || (program.strata[own].recursive && (at_site ? program.strata[own].local : program.strata[own].links)),
                   "rule {} reads {} in a stratum that does not say so", rule.name, p.name);
        MELD_CHECK(other != own || !negated || program.strata[own].rounds, "rule {} negates or aggregates {} of its own stratum", rule.name,
                   p.name);
    });
}

}  // namespace

void verify(const Program& program) {
    for (const Predicate& p : program.predicates) verify_predicate(program, p);
    for (const Rule& rule : program.rules) expect_well_formed(program, rule);
}

void verify_no_delays(const Program& program) {
    for (const Rule& rule : program.rules)
        each_head(rule.heads, [&](const Head& h) { MELD_CHECK(h.delay.op == Op::Anonymous, "a head of rule {} still waits", rule.name); });
}

void verify_relayed(const Program& program) {
    const auto heads = [&](const auto& self, const Rule& rule, const std::vector<Head>& all, const Places& around) -> void {
        for (const Head& h : all) {
            Places near = around;
            add_neighbours(program, rule, h.body, near);
            // A node that the rule makes.
            if (h.kind == Head::Kind::Set && h.term.op == Op::NewNode) near.insert(h.variable);
            if (h.kind == Head::Kind::Fact) {
                const VariableId at = h.atom.arguments[0].variable;
                MELD_CHECK(at == rule.site || near.contains(at), "rule {} sends {} further than to a neighbour", rule.name,
                           program.predicates[h.atom.predicate].name);
            }
            self(self, rule, h.heads, near);
            self(self, rule, h.others, h.kind == Head::Kind::Aggregate ? around : near);
        }
    };
    for (const Rule& rule : program.rules) {
        if (!rule.linear || rule.initial_fact) continue;
        Places near;
        add_neighbours(program, rule, rule.body, near);
        // A fact that is handed on goes to a catom that its text names, which was a neighbour when it was sent.
        if (!rule.arrives) heads(heads, rule, rule.heads, near);
    }
}

void verify_waits(const Program& program) {
    for (const Predicate& p : program.predicates) {
        if (!p.complete_link.valid()) continue;
        const Predicate& link = program.predicates[p.complete_link];
        MELD_CHECK(link.world != WorldSource::None || link.auxiliary, "{} waits over {}, which is no view of the neighbours", p.name,
                   link.name);
    }
}

void verify_given(const Program& program) {
    std::vector<bool> derived(program.predicates.count(), false);
    for (const Rule& rule : program.rules)
        if (!rule.linear) derived[rule.heads[0].atom.predicate.index()] = true;
    for (const Rule& rule : program.rules) {
        if (!rule.linear) continue;
        each_head(rule.heads, [&](const Head& h) {
            if (h.kind != Head::Kind::Fact) return;
            const Predicate& p = program.predicates[h.atom.predicate];
            MELD_CHECK(p.kind != PredicateKind::Persistent || !derived[h.atom.predicate.index()], "rule {} gives {}, which others derive",
                       rule.name, p.name);
        });
    }
}

void verify_localized(const Program& program) {
    for (const Rule& rule : program.rules) {
        Places near;
        add_neighbours(program, rule, rule.body, near);
        verify_places(program, rule, rule.body, {});
        verify_head_places(program, rule, rule.heads, near);
    }
}

void verify_strata(const Program& program) {
    const std::vector<std::size_t> stratum = stratum_of(program);
    std::vector<bool> placed(program.rules.count(), false);
    for (std::size_t i = 0; i < program.strata.size(); ++i)
        for (const RuleId id : program.strata[i].rules) {
            const Rule& rule = program.rules[id];
            MELD_CHECK(!rule.linear && !placed[id.index()], "rule {} is in two strata, or linear", rule.name);
            placed[id.index()] = true;
            MELD_CHECK(stratum[rule.heads[0].atom.predicate.index()] == i, "rule {} is in a stratum that it does not derive", rule.name);
            verify_reads(program, rule, i, stratum);
        }
    for (const RuleId id : program.rules.ids())
        MELD_CHECK(program.rules[id].linear || placed[id.index()], "rule {} is in no stratum", program.rules[id].name);
    for (const PredicateId p : program.predicates.ids())
        if (const PredicateId link = program.predicates[p].complete_link; link.valid())
            MELD_CHECK(stratum[link.index()] < stratum[p.index()], "{} waits over {}, which is evaluated later", program.predicates[p].name,
                       program.predicates[link].name);
}

}  // namespace meld::plan
