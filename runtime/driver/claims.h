// What must be the same on all processes of a run: see agreement.h.
#pragma once

#include <vector>

#include "runtime/driver/agreement.h"
#include "runtime/driver/options.h"
#include "runtime/module/module.h"
#include "runtime/world/world_file.h"

namespace meld::driver {

// Claymeld's version, the program's text, the module, the world with all files it names and the options that changed it, and the options
// that every process uses. The number of threads may differ: results do not depend on it.
std::vector<Claim> claims(const RunOptions& options, const Module& module, const world::World& world);

}  // namespace meld::driver
