// Constructs of the language that are rewritten to simpler ones, once a program has been checked: passes over programs, which
// the planner runs first. What they add are auxiliaries: predicates and rules that no user sees.
//
//     construct                      becomes                                                      where
//     p(A)@+3 in a head              a fact that waits, and a rule that ends the wait             delay.cpp
//     a head two links away          facts that neighbours hand on                                relay.cpp
//     type ... undelivered-p         a rule for what is a neighbour, one for what is not          undelivered.cpp
//     delta(X; p(A, X)) > 1          the same of a view that can be compared with what it was     watch.cpp
//     [<- route]                     the same over a view of the neighbours along the route       wait.cpp
//
// Constructs that need no types are rewritten before, by the check: on the syntax tree `stable(p(A), 5)` (compiler/check/stable.cpp),
// names of types (type_names.cpp) and of modules (modules.cpp); while names are resolved `forall p [q]`, `proved(N, p)`
// (resolve_body.cpp), `exists` and heads of views with several facts (resolve_heads.cpp) and patterns (patterns.cpp).
#pragma once

#include "compiler/check/program.h"

namespace meld::desugar {

// Rewrites facts for later to auxiliaries in which they wait, and rules that end the wait.
void delay_heads(check::Program& program);
// Rewrites facts for catoms more than one link away to auxiliaries that are handed on.
void relay_heads(check::Program& program);
// Lets facts that cannot be delivered come back, where the program declares that they do. Assumes relays.
void return_undelivered(check::Program& program);
// Gives facts whose change is tested a view that can be compared with what it was.
void watch_changes(check::Program& program);
// Gives aggregates that wait for neighbours over links of the program's own a view of the neighbours they wait for.
void wait_for_neighbours(check::Program& program);

}  // namespace meld::desugar
