// What all processes of a run must have alike: see agreement.h.
#pragma once

#include <vector>

#include "runtime/driver/agreement.h"
#include "runtime/driver/options.h"
#include "runtime/module/module.h"
#include "runtime/world/world_file.h"

namespace meld::driver {

// Claymeld's version, the program's text, the module, the world with all files it names and what the options changed in it, and the
// options that every process acts on. How many threads each has is its own matter: results do not depend on that.
std::vector<Claim> claims(const RunOptions& options, const Module& module, const world::World& world);

}  // namespace meld::driver
