// The planner's pipeline.
#include "compiler/plan/plan.h"

#include <algorithm>

#include "compiler/check/check.h"

namespace meld::plan {

namespace {

// The components of the program, with the predicates and rules that earlier passes have made.
void find_components(Plan& plan) {
    plan.program.components.clear();
    diagnostics::Reporter already_reported;
    check::stratify(plan.program, already_reported);
    split_trees(plan.program);
    lay_out(plan);
}

// A pass over the checked program, or, once there is a layout, over the plan.
struct Pass {
    std::string_view name;
    bool optional;
    void (*on_program)(check::Program&);
    void (*on_plan)(Plan&);
};

constexpr Pass kPasses[] = {
    {"fold", true, fold_constants, nullptr},
    {"dead", true, drop_dead_rules, nullptr},
    {"delay", false, delay_heads, nullptr},
    {"relay", false, relay_heads, nullptr},
    {"undelivered", false, return_undelivered, nullptr},
    {"watch", false, watch_changes, nullptr},
    {"wait", false, wait_for_neighbours, nullptr},
    {"given", false, separate_base, nullptr},
    {"exists", false, ask_for_existence, nullptr},
    {"localize", false, localize, nullptr},
    {"push", true, push_aggregates, nullptr},
    {"merge", true, merge_auxiliaries, nullptr},
    {"gather", true, gather_facts, nullptr},
    {"narrow", true, narrow_integers, nullptr},
    {"layout", false, nullptr, find_components},
    {"order", false, nullptr, order_rules},
    {"deltas", true, nullptr, plan_deltas},
    {"share", true, nullptr, share_prefixes},
};

}  // namespace

std::vector<std::string_view> passes(Passes which) {
    std::vector<std::string_view> names;
    for (const Pass& p : kPasses)
        if (which == Passes::All || p.optional) names.push_back(p.name);
    return names;
}

Plan make_plan(check::Program program, const PlanOptions& options) {
    Plan plan;
    plan.program = std::move(program);
    for (const Pass& p : kPasses) {
        if (std::find(options.without.begin(), options.without.end(), p.name) == options.without.end()) {
            if (p.on_program != nullptr) p.on_program(plan.program);
            if (p.on_plan != nullptr) p.on_plan(plan);
            if (p.on_program != nullptr)
                verify(plan.program);
            else
                verify(plan);
        }
        if (p.name == options.after) break;
    }
    return plan;
}

}  // namespace meld::plan
