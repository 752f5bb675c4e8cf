// The engines for comparison: the original design's, and unmodified ODE.
#pragma once

#include <memory>

#include "physics/solver/engine.h"

namespace meld::physics {

std::unique_ptr<Engine> make_hash_engine(World& world);
std::unique_ptr<Engine> make_ode_engine(World& world);

}  // namespace meld::physics
