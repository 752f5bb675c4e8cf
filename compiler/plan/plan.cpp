// The planner's pipeline.
#include "compiler/plan/plan.h"

#include <algorithm>

#include "compiler/check/check.h"

namespace meld::plan {

namespace {

struct Pass {
    std::string_view name;
    void (*run)(Plan&);
};
// What can be left out, in order.
constexpr Pass kOptional[] = {
    {"deltas", plan_deltas},
};

}  // namespace

std::vector<std::string_view> optional_passes() {
    std::vector<std::string_view> names;
    for (const Pass& p : kOptional) names.push_back(p.name);
    return names;
}

Plan make_plan(check::Program program, const PlanOptions& options) {
    Plan plan;
    delay_heads(program);
    relay_heads(program);
    watch_changes(program);
    separate_base(program);
    localize(program);
    program.components.clear();
    diagnostics::Reporter already_reported;
    check::stratify(program, already_reported);
    plan.program = std::move(program);
    lay_out(plan);
    order_rules(plan);
    verify(plan);
    for (const Pass& p : kOptional) {
        if (std::find(options.without.begin(), options.without.end(), p.name) != options.without.end()) continue;
        p.run(plan);
        verify(plan);
    }
    return plan;
}

namespace {

void verify_steps(const Plan& plan, const check::Rule& rule, const std::vector<Step>& steps) {
    for (const Step& s : steps) {
        verify_steps(plan, rule, s.inner);
        if (s.kind != Step::Kind::Match) continue;
        const check::Predicate& p = plan.program.predicates[s.predicate];
        MELD_CHECK(s.uses.size() == s.arguments.size() && s.arguments.size() + 1 == p.arguments.size(), "rule {}, {}", rule.name, p.name);
        MELD_CHECK(plan.of(s.predicate).storage != Storage::Unused, "rule {} reads {}, which is stored nowhere", rule.name, p.name);
        MELD_CHECK(s.at_home || p.world == check::WorldSource::None, "rule {} reads {} at a neighbour", rule.name, p.name);
        MELD_CHECK(s.at_home || plan.of(s.predicate).exported, "rule {} reads {} at a neighbour, and it is not exported", rule.name, p.name);
    }
}

}  // namespace

void verify(const Plan& plan) {
    const auto rules = [&](const std::vector<RulePlan>& all) {
        for (const RulePlan& r : all) verify_steps(plan, plan.program.rules[r.rule], r.steps);
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
