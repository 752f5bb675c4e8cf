// Catoms that follow their bodies to another process: with all their facts, their links, and what the new process must know of their
// neighbours.
#pragma once

#include "runtime/sim/bodies/contact_links.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// Takes a catom of this process or a ghost out; ghosts that only it touched go too, and those that stay look at their links again.
void take_out(Subdomain& subdomain, Catom catom);

// After bodies have changed hands; every process calls it.
void migrate_catoms(Subdomain& subdomain, const DividedBodies& divided, ContactLinks& links);

}  // namespace meld::sim
