// The state as a digest: all persistent and linear facts and all places, the same for any partition.
#pragma once

#include "runtime/base/hash.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::record {

// A digest of all facts that write_facts would write, and of where every catom stands; the same on every process.
// Cost: all facts.
Digest state_digest(sim::Subdomain& subdomain);

}  // namespace meld::record
