// The planner's pipeline: all passes in order, with the promises of each.
#include "compiler/plan/plan.h"

#include <algorithm>

#include "compiler/desugar/desugar.h"
#include "compiler/plan/verify.h"

namespace meld::plan {

namespace {

// A pass over the checked program, or, once there is a layout, over the plan. Its promises hold after all later passes too.
struct Pass {
    std::string_view name;
    enum class Kind { Needed, Optional } kind;
    void (*on_program)(check::Program&) = nullptr;
    void (*on_plan)(Plan&) = nullptr;
    void (*program_promise)(const check::Program&) = nullptr;
    void (*plan_promise)(const Plan&) = nullptr;
};

constexpr auto kNeeded = Pass::Kind::Needed;
constexpr auto kOptional = Pass::Kind::Optional;

constexpr Pass kPasses[] = {
    {.name = "fold", .kind = kOptional, .on_program = fold_constants},
    {.name = "dead", .kind = kOptional, .on_program = drop_dead_rules},
    {.name = "delay", .kind = kNeeded, .on_program = desugar::delay_heads, .program_promise = verify_no_delays},
    {.name = "relay", .kind = kNeeded, .on_program = desugar::relay_heads, .program_promise = verify_relayed},
    {.name = "undelivered", .kind = kNeeded, .on_program = desugar::return_undelivered},
    {.name = "watch", .kind = kNeeded, .on_program = desugar::watch_changes},
    {.name = "wait", .kind = kNeeded, .on_program = desugar::wait_for_neighbours, .program_promise = verify_waits},
    {.name = "given", .kind = kNeeded, .on_program = separate_base, .program_promise = verify_given},
    {.name = "exists", .kind = kNeeded, .on_program = ask_for_existence},
    {.name = "fronts", .kind = kNeeded, .on_program = keep_fronts},
    {.name = "localize", .kind = kNeeded, .on_program = localize, .program_promise = verify_localized},
    {.name = "push", .kind = kOptional, .on_program = push_aggregates},
    {.name = "merge", .kind = kOptional, .on_program = merge_auxiliaries},
    {.name = "gather", .kind = kOptional, .on_program = gather_facts},
    {.name = "narrow", .kind = kOptional, .on_program = narrow_integers},
    {.name = "strata", .kind = kNeeded, .on_program = find_strata, .program_promise = verify_strata},
    {.name = "ranked", .kind = kOptional, .on_program = narrow_ranked},
    {.name = "layout", .kind = kNeeded, .on_plan = lay_out, .plan_promise = verify_layout},
    {.name = "order", .kind = kNeeded, .on_plan = order_rules, .plan_promise = verify_steps},
    {.name = "deltas", .kind = kOptional, .on_plan = plan_deltas},
    {.name = "sweep", .kind = kOptional, .on_plan = plan_sweeps, .plan_promise = verify_sweeps},
    {.name = "singles", .kind = kOptional, .on_plan = find_singles},
    {.name = "letters", .kind = kOptional, .on_plan = find_letters},
    {.name = "pull", .kind = kOptional, .on_plan = find_pulled},
    {.name = "births", .kind = kOptional, .on_plan = find_idle_births},
    {.name = "share", .kind = kOptional, .on_plan = share_prefixes},
    {.name = "indexes", .kind = kOptional, .on_plan = choose_indexes},
    {.name = "search", .kind = kOptional, .on_plan = plan_searches},
};

// Checks the promises of the passes up to `last`.
void verify_after(const Pass& last, const Plan& plan) {
    verify(plan.program);
    for (const Pass& p : kPasses) {
        if (p.program_promise != nullptr) p.program_promise(plan.program);
        if (p.plan_promise != nullptr) p.plan_promise(plan);
        if (&p == &last) return;
    }
}

}  // namespace

std::vector<std::string_view> passes(Passes which) {
    std::vector<std::string_view> names;
    for (const Pass& p : kPasses)
        if (which == Passes::All || p.kind == kOptional) names.push_back(p.name);
    return names;
}

Plan make_plan(check::Program program, const PlanOptions& options) {
    Plan plan;
    plan.program = std::move(program);
    plan.counts = options.counts;
    plan.places = options.places || options.counts;
    plan.checked = options.checked;
    plan.program.by_links = options.links || plan.program.worlds == check::Worlds::Graphs;
    for (const Pass& p : kPasses) {
        if (std::find(options.without.begin(), options.without.end(), p.name) == options.without.end()) {
            if (p.on_program != nullptr) p.on_program(plan.program);
            if (p.on_plan != nullptr) p.on_plan(plan);
            verify_after(p, plan);
        }
        if (p.name == options.after) break;
    }
    return plan;
}

}  // namespace meld::plan
