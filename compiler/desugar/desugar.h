// Constructs of the language that are rewritten to simpler ones after a program has been checked: passes over programs, which the planner
// runs first. They add auxiliary predicates and rules that no user sees.
//
//     construct                      becomes                                                      where
//     p(A)@+3 in a head              a fact that waits, and a rule that ends the wait             delay.cpp
//     a head two links away          facts that neighbours hand on                                relay.cpp
//     a head that no link leads to   facts that find their way, in graphs                         relay.cpp
//     type ... undelivered-p         a rule for what is a neighbour, one for what is not          undelivered.cpp
//     delta(X; p(A, X)) > 1          the same of a view that can be compared with what it was     watch.cpp
//     [<- route]                     the same over a view of the neighbours along the route       wait.cpp
//
// Constructs that need no types are rewritten earlier, by the check: `stable(p(A), 5)` (compiler/check/names/stable.cpp) and the names of
// types (type_names.cpp) and modules (modules.cpp) on the syntax tree; `forall p [q]` and `proved(N, p)` (resolve_body.cpp), `exists` and
// heads of views with several facts (resolve_heads.cpp) and patterns (patterns.cpp) while names are resolved; and there the catoms that
// a rule names, @3, become variables (fixed_catoms.cpp).
#pragma once

#include "compiler/check/program/program.h"

namespace meld::desugar {

// Rewrites delayed facts to auxiliaries in which they wait, and rules that end the wait.
void delay_heads(check::Program& program);
// Rewrites facts for catoms more than one link away, or in graphs for any, to auxiliaries that are forwarded.
void relay_heads(check::Program& program);
// Returns facts that cannot be delivered, if the program declares that. Assumes relays.
void return_undelivered(check::Program& program);
// Gives facts whose change is tested a view that can be compared with what it was.
void watch_changes(check::Program& program);
// Gives aggregates that wait for neighbours over the program's own links a view of the neighbours they wait for.
void wait_for_neighbours(check::Program& program);

}  // namespace meld::desugar
