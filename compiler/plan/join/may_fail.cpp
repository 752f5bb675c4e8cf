#include "compiler/plan/join/may_fail.h"

#include <algorithm>
#include <string_view>

#include "compiler/check/program/op_info.h"

namespace meld::plan {

using check::Op;
using check::Program;

bool may_fail(const Program& program, const Term& term) {
    return check::any_subterm(term, [&](const Term& t) {
        if (t.op == Op::Constant) return program.constants[t.constant].computed.valid();
        return check::info(t.op).has(check::OpInfo::kPartial | check::OpInfo::kOverflows);
    });
}

bool may_fail(const Program& program, const std::vector<Term>& terms) {
    return std::any_of(terms.begin(), terms.end(), [&](const Term& t) { return may_fail(program, t); });
}

namespace {

bool step_may_fail(const Program& program, const Step& step) {
    if (const auto* over = as<AggregateOver>(step); over != nullptr && over->aggregate != check::Aggregate::Count) return true;
    bool may = false;
    each_part(step, [&](const Term& t) { may = may || may_fail(program, t); }, [](const VariableId&) {});
    const auto* inner = inner_steps(step);
    return may || (inner != nullptr && may_fail(program, *inner));
}

}  // namespace

bool may_fail(const Program& program, const std::vector<Step>& steps) {
    return std::any_of(steps.begin(), steps.end(), [&](const Step& s) { return step_may_fail(program, s); });
}

bool may_fail(const Program& program, const RulePlan& rule) {
    return may_fail(program, rule.steps) ||
           std::any_of(rule.heads.begin(), rule.heads.end(),
                       [&](const HeadPlan& h) {
                           const auto* fact = as<MakeFact>(h);
                           return fact != nullptr && may_fail(program, fact->arguments);
                       }) ||
           std::any_of(rule.branches.begin(), rule.branches.end(), [&](const RulePlan& b) { return may_fail(program, b); });
}

bool may_fail(const Program& program, const StratumPlan& stratum) {
    return std::any_of(stratum.rules.begin(), stratum.rules.end(), [&](const RulePlan& r) { return may_fail(program, r); }) ||
           std::any_of(stratum.predicates.begin(), stratum.predicates.end(),
                       [&](PredicateId p) { return fold_may_fail(program.predicates[p]); });
}

bool may_fail(const Plan& plan) {
    return std::any_of(plan.strata.begin(), plan.strata.end(), [&](const StratumPlan& s) { return may_fail(plan.program, s); });
}

bool fold_may_fail(const check::Predicate& p) {
    const std::string_view reduction = info(p.aggregate).reduction_name;
    return p.aggregate != check::Aggregate::Count && (reduction == "Combine" || reduction == "CombineInOrder");
}

bool fails_in_any_order(const Program& program, const RulePlan& rule) {
    // An expression before all facts fails for any facts.
    const auto is_fact = [](const Step& s) { return as<Match>(s) != nullptr; };
    const auto first_fact = std::find_if(rule.steps.begin(), rule.steps.end(), is_fact);
    if (first_fact == rule.steps.end()) return true;
    auto step = std::find_if(first_fact + 1, rule.steps.end(), [&](const Step& s) { return step_may_fail(program, s); });
    if (step == rule.steps.end()) return true;
    if (is_fact(*step)) {
        if (std::count_if(rule.steps.begin(), step, is_fact) > 1) return false;
    } else if (as<Test>(*step) == nullptr && as<Set>(*step) == nullptr) {
        return false;
    }
    Variables unsure;
    if (const Set* set = as<Set>(*step)) unsure.insert(set->variable);
    while (++step != rule.steps.end()) {
        bool depends = false;
        const auto note = [&](VariableId v) { depends = depends || unsure.contains(v); };
        each_part(*step, [&](const Term& t) { check::each_variable(t, note); }, [](const VariableId&) {});
        if (const Set* set = as<Set>(*step)) {
            if (depends || may_fail(program, set->value)) unsure.insert(set->variable);
        } else if (as<Test>(*step) == nullptr || !depends) {
            return false;
        }
    }
    return true;
}

}  // namespace meld::plan
