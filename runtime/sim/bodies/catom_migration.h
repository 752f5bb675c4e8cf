// Catoms that follow their bodies to another process: with all their facts, their links, and what the new process must know of their
// neighbours.
#pragma once

#include "runtime/sim/bodies/contact_links.h"
#include "runtime/sim/bodies/divided_bodies.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

// After bodies have changed hands; every process calls it.
void migrate_catoms(Subdomain& subdomain, const DividedBodies& divided, ContactLinks& links);

}  // namespace meld::sim
