// Emits what the heads of a comprehension compute from variables known outside it: the first match computes it, later ones reuse it.
// Nothing is computed where nothing matches, and what can fail does so at the same place as before.
#include "compiler/check/program/op_info.h"
#include "compiler/emit/rule_emitter.h"
#include "compiler/plan/join/invariant.h"

namespace meld::emit {

bool RuleEmitter::is_invariant(const Term& term) const {
    return plan::is_invariant(
        plan_.program, term, [&](VariableId v) { return v == scope_.rule.site || scope_.values.contains(v) || scope_.places.contains(v); });
}

void RuleEmitter::keep_invariant(const Term& t) {
    if (scope_.kept.contains(&t)) return;
    // What is cheaper than the test whether it is known is computed each time.
    if (!check::any_subterm(t, [](const Term& part) { return check::info(part.op).has(check::OpInfo::kDear); })) return;
    if (!is_invariant(t)) {
        for (const Term& operand : t.operands) keep_invariant(operand);
        return;
    }
    const std::string value = term(scope_, t);
    // Lists that the module contains are as good as computed.
    if (value.starts_with("({ static ")) return;
    const std::string name = fresh("same"), known = fresh("known");
    w_.line("{} {}{{}};", cpp_type(t.type), name);
    w_.line("bool {} = false;", known);
    scope_.kept[&t] = fmt::format("({0} ? {1} : ({0} = true, {1} = {2}))", known, name, value);
}

void RuleEmitter::keep_invariants(const std::vector<HeadPlan>& heads) {
    plan::each_head_plan(heads, [&](const HeadPlan& h) {
        if (const MakeFact* fact = as<MakeFact>(h))
            for (const Term& argument : fact->arguments) keep_invariant(argument);
    });
}

}  // namespace meld::emit
