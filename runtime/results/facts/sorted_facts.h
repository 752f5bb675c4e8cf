// Facts in the one order in which files and people get them: by catom, and then by arguments.
#pragma once

#include <utility>
#include <vector>

#include "runtime/sim/core/subdomain.h"

namespace meld::record {

// The catoms of this process with their numbers, by these.
std::vector<std::pair<u64, sim::Catom>> catoms_by_id(const sim::Subdomain& subdomain);

// The arguments of a predicate's facts at a catom, in order. After Subdomain::refresh().
std::vector<std::vector<Value>> sorted_facts(const sim::Subdomain& subdomain, u32 predicate, sim::Catom catom);

}  // namespace meld::record
