// The whole module, part by part.
#include "compiler/emit/emit.h"

#include <algorithm>

#include "compiler/emit/marks.h"
#include "compiler/emit/writer.h"

namespace meld::emit {

std::string emit_module(const plan::Plan& plan) {
    MELD_EXPECT(plan.stored.size() == plan.program.predicates.count(), "a plan without a layout reached emission");
    Writer w;
    w.line("// {}, compiled by meldc. Bytes a catom: {}.", clean(plan.program.name), plan::bytes_per_catom(plan));
    if (plan.counts) w.raw("#define MELD_COUNTS");
    if (plan.checked) w.raw("#define MELD_CHECKED");
    if (plan.program.by_links) w.raw("#define MELD_BY_LINKS");
    w.line("#include \"runtime/module/kernel/{}.h\"", has_deltas(plan) ? "deltas" : "views");
    if (plan.singles.apply()) w.raw("#include \"runtime/module/kernel/singles.h\"");
    if (has_lookups(plan)) w.raw("#include \"runtime/module/kernel/index.h\"");
    if (std::ranges::any_of(plan.strata, [](const plan::StratumPlan& s) { return !s.semi_naive.empty(); }))
        w.raw("#include \"runtime/module/kernel/rounds.h\"");
    if (keeps_fronts(plan)) w.raw("#include \"runtime/module/kernel/fronts.h\"");
    if (plan.counts) w.raw("#include \"runtime/module/kernel/counts.h\"");
    if (plan.places) w.raw("#include \"runtime/module/abi/counts_abi.h\"");
    w.raw("");
    w.raw("using namespace meld;");
    emit_externs(plan, w);
    w.raw("namespace {");
    emit_types(plan, w);
    emit_records(plan, w);
    emit_predicates(plan, w);
    emit_searches(plan, w);
    emit_self(plan, w);
    emit_load_and_save(plan, w);
    emit_functions(plan, w);
    emit_facts(plan, w);
    for (const plan::StratumPlan& s : plan.strata)
        for (const RulePlan& r : s.rules) emit_view_rule(plan, r, w);
    for (const plan::StratumPlan& s : plan.strata) emit_deltas(plan, s, w);
    for (const RulePlan& r : plan.initial_facts) emit_linear_rule(plan, r, true, w);
    const bool marks = !fixed_marks(plan);
    for (const RulePlan& r : plan.linear_rules) emit_linear_rule(plan, r, marks, w);
    emit_singles(plan, w);
    emit_strata(plan, w);
    emit_concerned(plan, w);
    emit_stops(plan, w);
    emit_evaluate(plan, w);
    emit_schema(plan, w);
    w.raw("");
    w.raw("}  // namespace");
    w.raw("");
    w.raw("extern \"C\" __attribute__((visibility(\"default\"))) const void* claymeld_module() { return &kModule; }");
    return w.text();
}

}  // namespace meld::emit
