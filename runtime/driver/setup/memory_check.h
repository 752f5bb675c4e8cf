// Whether the world fits into memory; called before anything is allocated.
#pragma once

#include <string>

#include "runtime/driver/setup/memory_need.h"

namespace meld::driver {

// Refuses a world whose catoms surely need more memory than this machine has free (or than [limits] memory allows), naming both.
// processes_here: how many processes share this machine.
Result<void> check_memory(const world::World& world, const MemoryNeed& need, int processes_here);

// A warning if it may need more, depending on the facts that catoms will have; else empty.
std::string warning_of_memory(const world::World& world, const MemoryNeed& need, int processes_here);

}  // namespace meld::driver
