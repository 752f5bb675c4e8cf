// The limits of a run: what stands in [limits] or --limit, and otherwise what follows from memory.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/base/error.h"
#include "runtime/world/description/world.h"

namespace meld::world {

// Replaces a limit: "facts=50000", or derivations, ticks, list or memory ("memory=2GiB"). Errors: no such limit or value.
Result<void> set_limit(World& world, const std::string& setting);
// The limits of this kind that a run has: where its rules can make only so many facts, and where they may make ever more, because they
// compute arguments from facts of their own. `memory_bytes`: what the run may take.
struct FactLimits {
    std::uint64_t bounded = 0, growing = 0;
};
FactLimits fact_limits(const Limits& limits, std::uint64_t memory_bytes);
// Of the firings of linear rules, and of recursion of the two kinds; one that ends by itself has none unless the world says so.
struct DerivationLimits {
    std::uint64_t firings = 0, finite = 0, growing = 0;
};
DerivationLimits derivation_limits(const Limits& limits);

}  // namespace meld::world
