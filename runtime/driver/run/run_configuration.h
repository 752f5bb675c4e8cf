// What must be the same on all processes of a run: see configuration_agreement.h.
#pragma once

#include <vector>

#include "runtime/driver/run/configuration_agreement.h"
#include "runtime/driver/setup/options.h"
#include "runtime/module/load/module.h"
#include "runtime/world/description/world.h"

namespace meld::driver {

// The name of the claim about the numbers of ports. A run that branches off may not change them: they are in what catoms hold.
inline constexpr const char* kPortsClaim = "the ports";

// Claymeld's version, the program's text, the module, the world with all files it names and the options that changed it, and the options
// that every process uses. The number of threads may differ: results do not depend on it.
std::vector<Claim> claims(const RunOptions& options, const Module& module, const world::World& world);

}  // namespace meld::driver
