// The engines that exist for comparison: the seed design's, and ODE as it is.
#pragma once

#include <memory>

#include "physics/engine.h"

namespace meld::physics {

std::unique_ptr<Engine> make_hash_engine(World& world);
std::unique_ptr<Engine> make_ode_engine(World& world);

}  // namespace meld::physics
