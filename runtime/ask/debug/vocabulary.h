// The names of a run, for completion.
#pragma once

#include <string>

#include "runtime/ask/debug/completion.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::debug {

// Catoms are those of this process. Valid as long as the subdomain is at this tick. Cost: reads the program that the module carries.
Vocabulary vocabulary_of(const sim::Subdomain& subdomain, const std::string& folder);

}  // namespace meld::debug
