// The promises of each pass; make_plan() checks them after that pass and after all later ones. A violation is our bug and ends the process.
#pragma once

#include "compiler/plan/plan.h"

namespace meld::plan {

// For every program: ids are valid, arguments fit their predicates, views have one head.
void verify(const check::Program& program);
// For a program after the pass `delay`: delayed facts have become auxiliaries.
void verify_no_delays(const check::Program& program);
// After `relay`: linear rules send to their own catom and its neighbours.
void verify_relayed(const check::Program& program);
// After `wait`: aggregates wait over `neighbor` or a view of the neighbours.
void verify_waits(const check::Program& program);
// After `given`: facts that rules derive are not also given.
void verify_given(const check::Program& program);
// After `localize`: a rule reads at its execution site and at direct neighbours, where it reads only what is stored.
void verify_localized(const check::Program& program);
// After `strata`: every rule reads only predicates that are evaluated earlier or with it, and negates or aggregates only the earlier ones.
void verify_strata(const check::Program& program);

// For a plan after `layout`: every stored predicate lies in its column and overlaps no other.
void verify_layout(const Plan& plan);
// After `order`: steps use variables that earlier ones have bound, and read predicates that are stored and exported. The same holds in
// delta rules and shared prefixes.
void verify_steps(const Plan& plan);
// After `sweep`: a rule that takes all messages in one pass reads one state and one message.
void verify_sweeps(const Plan& plan);

}  // namespace meld::plan
