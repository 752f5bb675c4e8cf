// The state as text and as a digest: all persistent and linear facts, the same for any partition.
#pragma once

#include "runtime/base/error.h"
#include "runtime/base/hash.h"
#include "runtime/base/output_file.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::record {

// Writes all facts at the end, one per line in Meld syntax, sorted by predicate, then catom id, then arguments; all processes call it,
// process 0 writes, and only process 0 has the file. Auxiliary predicates and actions are left out. The file is committed. Errors, on every
// process: the file cannot be written. Cost: the facts of one predicate at a time pass through process 0.
Result<void> write_facts(sim::Subdomain& part, OutputFile* file);

// A digest of all facts that write_facts would write, and of the position of every catom; the same on every process.
// Cost: all facts.
Digest state_digest(sim::Subdomain& part);

}  // namespace meld::record
