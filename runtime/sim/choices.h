// The implementations that a world chooses by name.
#pragma once

#include "runtime/base/error.h"
#include "runtime/sim/core/extension.h"

namespace meld::sim {

// Checks that the registry has everything that a world chooses: its motion and its components. Errors name file and key.
Result<void> check_choices(const Registry& registry, const world::World& world);

}  // namespace meld::sim
