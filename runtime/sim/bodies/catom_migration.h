// Catoms that follow their bodies to another process: with all their facts, their links, and what the new process must know about their
// neighbours.
#pragma once

#include "runtime/sim/bodies/contact_links.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// Removes a catom of this process or a ghost; ghosts that only it touched are removed too, and those that stay check their links again.
void take_out(Subdomain& subdomain, Catom catom);

// After bodies have migrated; every process calls it.
void migrate_catoms(Subdomain& subdomain, const DividedBodies& divided, ContactLinks& links);

}  // namespace meld::sim
