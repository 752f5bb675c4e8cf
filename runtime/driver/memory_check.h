// Whether the world fits into memory; called before anything is allocated.
#pragma once

#include <cstdint>

#include "runtime/abi/module_abi.h"
#include "runtime/base/error.h"
#include "runtime/world/world_file.h"

namespace meld::driver {

// Refuses a world whose catoms need more memory than this machine has free (or than [limits] memory allows), naming both.
// processes_here: how many processes share this machine. Returns the estimate in bytes for one process.
Result<std::uint64_t> check_memory(const world::World& world, const ModuleInfo& module, int processes, int processes_here);

}  // namespace meld::driver
