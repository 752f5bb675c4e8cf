// Will it fit? Asked before anything is allocated.
#pragma once

#include <cstdint>

#include "runtime/abi/module_abi.h"
#include "runtime/base/error.h"
#include "runtime/world/world_file.h"

namespace meld::driver {

// Refuses a world whose catoms need more memory than this machine has free (or than [limits] memory allows), naming both.
// parts_here: how many parts share this machine. Returns the estimate in bytes for one part.
Result<std::uint64_t> check_memory(const world::World& world, const ModuleInfo& module, int parts, int parts_here);

}  // namespace meld::driver
