// The dirty bits on which steps depend: after a change of anything else they have the same result.
#include "compiler/plan/join/order.h"
#include "runtime/module/abi/senses.h"

namespace meld::plan {

using namespace check;

namespace {

std::uint64_t of_match(const Plan& plan, const Match& m) {
    const WorldSource world = plan.program.predicates[m.predicate].world;
    if (world != WorldSource::None) return info(world).wakes;
    const Column& column = plan.column_of(m.predicate);
    const std::uint64_t per_link = plan.of(m.predicate).storage == Storage::PerLink ? std::uint64_t{kDirtyLinks} : 0;
    return per_link | (m.at_site ? column.own_dirty : column.reader_dirty | kDirtyLinks);
}

std::uint64_t of_step(const Plan& plan, const Step& step) {
    return visit_step<std::uint64_t>(
        step,  //
        [&](const Match& m) { return of_match(plan, m); }, [](const EachNeighbour&) { return kDirtyLinks; },
        [](const FindNeighbour&) { return kDirtyLinks; },
        // A change is true in one tick only.
        [](const ChangeSince&) { return kDirtyWake; }, [](const auto&) { return 0; });
}

}  // namespace

std::uint64_t inputs_of(const Plan& plan, const std::vector<Step>& steps) {
    std::uint64_t bits = kDirtyBorn;
    each_step(steps, [&](const Step& step) {
        bits |= of_step(plan, step);
        // What is due is so when the time has come.
        const auto due = [&](const Term& t) { bits |= t.op == Op::Due ? std::uint64_t{kDirtyWake} : 0; };
        each_part(step, [&](const Term& t) { each_subterm(t, due); }, [](VariableId) {});
    });
    return bits;
}

std::uint64_t inputs_of(const Plan& plan, const std::vector<HeadPlan>& heads) {
    std::uint64_t bits = 0;
    each_head_plan(heads, [&](const HeadPlan& h) {
        if (const std::vector<Step>* steps = steps_of(h)) bits |= inputs_of(plan, *steps);
    });
    return bits;
}

std::uint64_t absent_inputs(const Plan& plan, const std::vector<Step>& steps) {
    std::uint64_t bits = 0;
    for (const Step& outer : steps) {
        const std::vector<Step>* inner = inner_steps(outer);
        if (inner == nullptr) continue;
        each_step(*inner, [&](const Step& step) {
            const Match* m = as<Match>(step);
            if (m != nullptr && plan.program.predicates[m->predicate].linear()) bits |= plan.column_of(m->predicate).own_dirty;
        });
    }
    return bits;
}

std::uint64_t waiting_inputs(const Plan& plan, PredicateId predicate) {
    const PredicateId link = plan.program.predicates[predicate].complete_link;
    if (!link.valid()) return 0;
    return plan.program.predicates[link].world != WorldSource::None ? std::uint64_t{kDirtyLinks}
                                                                    : kDirtyLinks | plan.column_of(link).own_dirty;
}

}  // namespace meld::plan
