// What every pass leaves true; a violation is our bug and ends the process.
#include "compiler/plan/plan.h"

namespace meld::plan {

namespace {

void verify_atom(const check::Program& program, const check::Rule& rule, const check::Atom& a) {
    MELD_CHECK(a.predicate.valid() && a.predicate.index() < program.predicates.count(), "rule {} names no predicate", rule.name);
    const check::Predicate& p = program.predicates[a.predicate];
    MELD_CHECK(a.arguments.size() == p.arguments.size(), "rule {}, {}", rule.name, p.signature());
    MELD_CHECK(a.arguments[0].is_variable(), "rule {} has {} at no catom", rule.name, p.name);
    for (const check::Term& t : a.arguments)
        check::each_variable(
            t, [&](VariableId v) { MELD_CHECK(v.valid() && v.index() < rule.variables.count(), "rule {}, {}", rule.name, p.name); });
}

void verify_steps(const Plan& plan, const check::Rule& rule, const std::vector<Step>& steps) {
    for (const Step& s : steps) {
        verify_steps(plan, rule, s.inner);
        if (s.kind != Step::Kind::Match) continue;
        const check::Predicate& p = plan.program.predicates[s.predicate];
        MELD_CHECK(s.uses.size() == s.arguments.size() && s.arguments.size() + 1 == p.arguments.size(), "rule {}, {}", rule.name, p.name);
        MELD_CHECK(plan.of(s.predicate).storage != Storage::Unused, "rule {} reads {}, which is stored nowhere", rule.name, p.name);
        MELD_CHECK(s.at_home || p.world == check::WorldSource::None, "rule {} reads {} at a neighbour", rule.name, p.name);
        MELD_CHECK(s.at_home || plan.of(s.predicate).exported, "rule {} reads {} at a neighbour, and it is not exported", rule.name,
                   p.name);
        MELD_CHECK(!s.changed || plan.of(s.predicate).storage == Storage::Rows, "rule {} follows the rows of {}, which has none", rule.name,
                   p.name);
    }
}

}  // namespace

void verify(const check::Program& program) {
    for (const check::Rule& rule : program.rules) {
        check::each_atom(rule.body, [&](const check::Atom& a, bool) { verify_atom(program, rule, a); });
        check::each_head(rule.heads, [&](const check::Head& h) {
            if (h.kind == check::Head::Kind::Fact) verify_atom(program, rule, h.atom);
            check::each_atom(h.body, [&](const check::Atom& a, bool) { verify_atom(program, rule, a); });
        });
        MELD_CHECK(rule.linear || rule.heads.size() == 1, "view {} has {} heads", rule.name, rule.heads.size());
    }
}

void verify(const Plan& plan) {
    const auto rules = [&](const std::vector<RulePlan>& all) {
        for (const RulePlan& r : all) {
            verify_steps(plan, plan.program.rules[r.rule], r.steps);
            for (const RulePlan& b : r.branches) verify_steps(plan, plan.program.rules[b.rule], b.steps);
            MELD_CHECK(r.branches.empty() || r.heads.empty(), "rule {} has heads and branches", plan.program.rules[r.rule].name);
        }
    };
    for (const ComponentPlan& c : plan.components) {
        rules(c.rules);
        rules(c.deltas.touches);
        rules(c.deltas.groups);
    }
    rules(plan.linear_rules);
    rules(plan.births);
}

}  // namespace meld::plan
