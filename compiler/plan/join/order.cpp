// Pass: join order. Turns every body into steps. Clauses without a new catom come first, cheap and bound facts before unbound ones
// (access.cpp has the costs), and a link only when nothing else is left; linear rules keep the order of the text, which is their meaning.
// Assumes localized rules and a layout.
#include "compiler/plan/join/order.h"

#include <algorithm>

#include "compiler/plan/join/body_order.h"

namespace meld::plan {

using namespace check;

namespace {

Variables head_variables(const std::vector<Head>& heads) {
    Variables out;
    for (const Head& h : heads) each_variable(h, [&](VariableId v) { out.insert(v); });
    return out;
}

std::vector<HeadPlan> plan_heads(const BodyOrder& orderer, const std::vector<Head>& heads, const Known& known);

MakeFact plan_fact(const Head& h) {
    return {.predicate = h.atom.predicate,
            .place = h.atom.arguments[0].variable,
            .arguments = {h.atom.arguments.begin() + 1, h.atom.arguments.end()}};
}

ForAll plan_matches(const BodyOrder& orderer, const Head& h, const Known& known) {
    Variables used = head_variables(h.heads);
    for (const HeadAggregate& a : h.aggregates)
        if (a.each.valid()) used.insert(a.each);
    Known inner = known;
    ForAll out;
    out.steps = orderer.order(h.body, inner, Reading::AsWritten, used);
    out.heads = plan_heads(orderer, h.heads, inner);
    return out;
}

HeadPlan plan_head(const BodyOrder& orderer, const Head& h, const Known& known) {
    Known inner = known;
    switch (h.kind) {
        case Head::Kind::Fact:
            return {plan_fact(h)};
        case Head::Kind::Comprehension:
            return {plan_matches(orderer, h, known)};
        case Head::Kind::Aggregate:
            for (const HeadAggregate& a : h.aggregates) inner.values.insert(a.result);
            return {AggregateAll{plan_matches(orderer, h, known), h.aggregates, plan_heads(orderer, h.others, inner)}};
        case Head::Kind::If:
            return {Choose{h.term, plan_heads(orderer, h.heads, known), plan_heads(orderer, h.others, known)}};
        case Head::Kind::Set:
            inner.values.insert(h.variable);
            return {With{h.variable, h.term, plan_heads(orderer, h.heads, inner)}};
    }
    return {};
}

std::vector<HeadPlan> plan_heads(const BodyOrder& orderer, const std::vector<Head>& heads, const Known& known) {
    std::vector<HeadPlan> out;
    for (const Head& h : heads) out.push_back(plan_head(orderer, h, known));
    return out;
}

// The heads of a whole rule.
std::vector<HeadPlan> rule_heads(const BodyOrder& orderer, const Rule& rule, const Known& known) {
    std::vector<HeadPlan> heads = plan_heads(orderer, rule.heads, known);
    for (HeadPlan& h : heads)
        if (MakeFact* fact = as<MakeFact>(h)) fact->contributors = rule.contributors;
    return heads;
}

RulePlan plan_rule(const Plan& plan, RuleId id, const std::vector<PredicateId>& ranked) {
    const Rule& rule = plan.program.rules[id];
    const BodyOrder orderer(plan, rule, ranked);
    Known known = orderer.start();
    Variables used = head_variables(rule.heads);
    if (rule.selected.valid()) used.insert(rule.selected);
    RulePlan out;
    out.rule = id;
    out.steps = orderer.order(rule.body, known, rule.linear ? Reading::AsWritten : Reading::Cheapest, used);
    out.heads = rule_heads(orderer, rule, known);
    out.inputs = inputs_of(plan, out.steps) | inputs_of(plan, out.heads);
    if (rule.linear) out.absent = absent_inputs(plan, out.steps);
    return out;
}

bool is_ranked(const Plan& plan, const std::vector<PredicateId>& predicates) { return plan.of(predicates[0]).ranked; }

// The predicates whose ranks count in the rules of a stratum.
std::vector<PredicateId> ranked_of(const Plan& plan, const std::vector<PredicateId>& predicates) {
    return is_ranked(plan, predicates) ? predicates : std::vector<PredicateId>{};
}

bool keeps_front(const Plan& plan, const check::Stratum& c) {
    return std::any_of(c.predicates.begin(), c.predicates.end(),
                       [&](PredicateId p) { return plan.program.predicates[p].front != Aggregate::None; });
}

Recursion recursion_of(const Plan& plan, const check::Stratum& c) {
    if (!c.recursive) return Recursion::None;
    if (c.tree && !c.local) return Recursion::Tree;
    if (c.rounds) return Recursion::Rounds;
    if (!is_ranked(plan, c.predicates)) return Recursion::LocalSets;
    return c.local || c.predicates.size() > 1 || keeps_front(plan, c) ? Recursion::Mutual : Recursion::Ranked;
}

StratumPlan plan_stratum(const Plan& plan, const check::Stratum& c) {
    StratumPlan out;
    out.predicates = c.predicates;
    out.links = c.links;
    out.recursion = recursion_of(plan, c);
    for (const RuleId id : c.rules) {
        out.rules.push_back(plan_rule(plan, id, ranked_of(plan, c.predicates)));
        out.inputs |= out.rules.back().inputs;
    }
    for (const PredicateId p : c.predicates) {
        out.inputs |= waiting_inputs(plan, p);
        out.outputs |= plan.column_of(p).own_dirty;
    }
    // A quarantine ends.
    if (is_ranked(plan, c.predicates) && c.links) out.inputs |= kDirtyWake;
    return out;
}

}  // namespace

std::vector<Step> order_changed(const Plan& plan, const Rule& rule, std::vector<Clause> body, std::size_t first,
                                const std::vector<VariableId>& needed) {
    const BodyOrder orderer(plan, rule);
    const Variables used{needed.begin(), needed.end()};
    Known known = orderer.start();
    std::vector<Step> steps = orderer.start_changed(body, first, used, known);
    if (std::all_of(needed.begin(), needed.end(), [&](VariableId v) { return known.has(v); })) return steps;
    for (Step& s : orderer.order(std::move(body), known, Reading::Cheapest, used)) steps.push_back(std::move(s));
    return steps;
}

RulePlan order_semi_naive(const Plan& plan, RuleId id, std::vector<Clause> body, std::size_t first,
                          const std::vector<PredicateId>& growing) {
    const Rule& rule = plan.program.rules[id];
    const BodyOrder orderer(plan, rule, {}, growing);
    Known known = orderer.start();
    const Variables used = head_variables(rule.heads);
    RulePlan out;
    out.rule = id;
    out.steps = orderer.start_changed(body, first, used, known);
    for (Step& s : orderer.order(std::move(body), known, Reading::Cheapest, used)) out.steps.push_back(std::move(s));
    out.heads = rule_heads(orderer, rule, known);
    return out;
}

RulePlan order_group(const Plan& plan, RuleId id, const StratumPlan& stratum, const std::vector<Clause>& body,
                     const std::vector<VariableId>& given) {
    const Rule& rule = plan.program.rules[id];
    const BodyOrder orderer(plan, rule, ranked_of(plan, stratum.predicates));
    Known known = orderer.start();
    known.values.insert(given.begin(), given.end());
    RulePlan out;
    out.rule = id;
    out.steps = orderer.order(body, known, Reading::Cheapest, head_variables(rule.heads));
    out.heads = rule_heads(orderer, rule, known);
    out.given = given;
    return out;
}

void order_rules(Plan& plan) {
    MELD_EXPECT(plan.strata.empty() && plan.stored.size() == plan.program.predicates.count(), "no layout, or ordered twice");
    for (const check::Stratum& c : plan.program.strata)
        if (!c.rules.empty()) plan.strata.push_back(plan_stratum(plan, c));
    // Arriving facts are there before the program's own rules are tried.
    for (const bool arrivals : {true, false})
        for (const RuleId id : plan.program.rules.ids()) {
            const Rule& rule = plan.program.rules[id];
            if (rule.linear && rule.arrives == arrivals)
                (rule.initial_fact ? plan.initial_facts : plan.linear_rules).push_back(plan_rule(plan, id, {}));
        }
    const auto reads_tick = [](const auto& all) {
        return std::any_of(all.begin(), all.end(), [](const auto& x) { return (x.inputs & kDirtyTick) != 0; });
    };
    plan.reads_tick = reads_tick(plan.strata) || reads_tick(plan.linear_rules);
}

}  // namespace meld::plan
