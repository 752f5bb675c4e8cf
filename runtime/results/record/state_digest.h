// The state as a digest: all persistent and linear facts and all places, the same for any partition.
#pragma once

#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/hash.h"
#include "runtime/base/large_array.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/state/changed_chunks.h"

namespace meld::record {

// A digest of all facts that write_facts would write, and of where every catom stands; the same on every process.
// Cost: all facts.
Digest state_digest(sim::Subdomain& subdomain);

// The same by chunks: 16 bytes for each, and a chunk that has changed is looked at as a whole.
class ChunkDigest {
  public:
    // As state_digest(). The chunks are always the same ones, after look(). Cost: all facts of those that have changed. Collective.
    Digest of(sim::Subdomain& subdomain, const sim::ChangedChunks& chunks);

  private:
    std::vector<Digest> parts_;  // By chunk.
    Digest sum_;                 // Of this process.
};

// The same digest of one subdomain again and again. It is a sum over catoms, so only those that may have changed are looked at: what they
// added before is taken out, and what they add now is put in. Keeps 16 bytes a catom.
class RunningDigest {
  public:
    // As state_digest(). Cost: at first all facts, then those of the catoms that have been touched since. Every process calls it.
    Digest of(sim::Subdomain& subdomain);
    // Errors: it is not that of the whole state after of(); names the tick and the catom with the least number whose part is another one.
    // Every process calls it. Cost: all facts.
    Result<void> check(sim::Subdomain& subdomain) const;

  private:
    sim::Touched* touched_ = nullptr;  // The subdomain's.
    LargeArray<Digest> parts_;         // By catom; of one that is not here nothing.
    Digest sum_;                       // Of this process.
    std::vector<sim::Catom> catoms_;   // Room for those that have been touched.
};

}  // namespace meld::record
