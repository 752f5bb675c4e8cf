// The state as text and as a digest: all persistent and linear facts, the same for any partition.
#pragma once

#include <string>

#include "runtime/base/error.h"
#include "runtime/base/hash.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::record {

// Writes all facts at the end, one a line in Meld syntax, sorted by predicate, then catom id, then arguments; process 0
// writes, all processes call. Auxiliary predicates and actions are left out. The file appears when it is complete;
// "-" is standard output.
// Errors: the file cannot be written. Cost: the facts of one predicate at a time pass through process 0.
Result<void> write_facts(sim::Subdomain& part, const std::string& path);

// A digest of all facts that write_facts would write, and of where every catom stands; the same on every process.
// Cost: all facts.
Digest state_digest(sim::Subdomain& part);

// Whether a file can be written at this path: nobody should learn that at the end of a long run.
Result<void> check_writable(const std::string& path);

}  // namespace meld::record
